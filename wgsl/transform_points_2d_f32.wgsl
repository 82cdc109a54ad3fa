#import real_f32
#import transform_points_2d
