// Whether a flag of a uniform is set, asked with a number that differs between invocations. lavapipe compiles a shader
// anew at each dispatch for what its conditions take from uniforms alone, if much of it falls away then.
fn is_set(flag: u32, any_index: u32) -> bool {
    return (flag & (any_index | 1u)) != 0u;
}
