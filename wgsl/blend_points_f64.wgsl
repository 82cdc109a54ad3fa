#import real_f64
#import blend_points
