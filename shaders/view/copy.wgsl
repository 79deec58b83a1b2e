// Puts the finished picture of the relief view into the window.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var soft: sampler;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let uv = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    var out: Corner;
    out.position = vec4<f32>(uv * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0), 0.0, 1.0);
    out.uv = uv;
    return out;
}

@fragment
fn shown(in: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(textureSample(picture, soft, in.uv).rgb, 1.0);
}
