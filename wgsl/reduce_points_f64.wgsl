#import real_f64
#import reduce_points
