// The number type of a stage: single precision.
alias Real = f32;
alias Vec2 = vec2<f32>;
alias Vec3 = vec3<f32>;
alias Vec4 = vec4<f32>;
alias Mat4 = mat4x4<f32>;
alias UniformVec4s = array<Vec4, 4096>; // 64 KiB, the least that WebGPU lets a uniform binding be
