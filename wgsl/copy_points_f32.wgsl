#import real_f32
#import copy_points
