#import real_f64
#import project_vertices
