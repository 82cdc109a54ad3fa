#import real_f64
#import transform_points
