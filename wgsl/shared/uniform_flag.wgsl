// Whether a flag of a uniform is set, asked by one of many. lavapipe compiles a shader anew at each dispatch for what its
// conditions take from uniforms alone, if much of it falls away then.
fn is_asked(flag: u32, asker: u32) -> bool {
    return (flag & (asker | 1u)) != 0u;
}
