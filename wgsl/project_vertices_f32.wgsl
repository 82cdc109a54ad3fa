#import real_f32
#import project_vertices
