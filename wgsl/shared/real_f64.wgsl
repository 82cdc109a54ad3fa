// The number type of a stage: double precision.
alias Real = f64;
alias Vec2 = vec2<f64>;
alias Vec3 = vec3<f64>;
alias Vec4 = vec4<f64>;
alias Mat4 = mat4x4<f64>;
alias UniformVec4s = array<Vec4, 2048>; // 64 KiB, the least that WebGPU lets a uniform binding be
