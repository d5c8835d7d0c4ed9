// One grey, as the target stores it.
override GREY: f32 = 0.0;

// One triangle that covers the viewport.
@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(uv * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn shade() -> @location(0) vec4f {
    return vec4f(GREY, GREY, GREY, 1.0);
}
