#import real_f32
#import blend_points
