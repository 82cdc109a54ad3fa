#import real_f64
#import transform_in_place
