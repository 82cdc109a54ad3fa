#import real_f32
#import reduce_points
