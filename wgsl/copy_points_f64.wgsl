#import real_f64
#import copy_points
