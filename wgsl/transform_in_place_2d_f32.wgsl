#import real_f32
#import transform_in_place_2d
