// The terrain of the editor's relief view: pieces of a grid whose heights come from a texture, under a draped picture.

struct Scene {
    to_screen: mat4x4<f32>,
    // East, south: where sample (0, 0) stands from the middle of the terrain, in metres; then the cell, then the
    // factor on heights.
    place: vec4<f32>,
    // Columns, rows of samples; the height of the water over the middle of the heights, then whether there is any.
    size: vec4<f32>,
    // The middle of the heights; how far skirts reach down.
    heights: vec4<f32>,
    water: vec4<f32>,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var field: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_2d<f32>;
@group(0) @binding(3) var soft: sampler;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) side: f32,
}

fn height(at: vec2<i32>) -> f32 {
    return (textureLoad(field, at, 0).x - scene.heights.x) * scene.place.w;
}

fn stand(sample: vec2<f32>, z: f32) -> vec4<f32> {
    let metres = scene.place.xy + sample * scene.place.z;
    return scene.to_screen * vec4<f32>(metres, z, 1.0);
}

// A corner of a piece: `part` is its column and row in the piece and how far down its skirt goes; `piece` is the first
// sample and the stride.
@vertex
fn ground(@location(0) part: vec3<f32>, @location(1) piece: vec3<f32>) -> Corner {
    let last = scene.size.xy - 1.0;
    let sample = min(piece.xy + part.xy * piece.z, last);
    // At the border of the terrain the walls close the block, and a skirt would lie in their plane.
    let inside = all(sample > vec2<f32>(0.0)) && all(sample < last);
    let skirt = select(0.0, part.z * piece.z * scene.place.z * 2.0, inside);
    let z = height(vec2<i32>(sample)) - skirt;
    var out: Corner;
    out.position = stand(sample, z);
    out.uv = (sample + 0.5) / scene.size.xy;
    out.side = 0.0;
    return out;
}

// The cut sides of the block: `part` is the sample and whether the corner is at the foot.
@vertex
fn wall(@location(0) part: vec3<f32>) -> Corner {
    // Water stands at the side as high as it is.
    let ground = height(vec2<i32>(part.xy));
    let flooded = scene.size.w > 0.5 && ground < scene.size.z;
    let top = select(ground, scene.size.z, flooded);
    let z = select(top, scene.heights.y, part.z > 0.5);
    var out: Corner;
    out.position = stand(part.xy, z);
    out.uv = (part.xy + 0.5) / scene.size.xy;
    out.side = select(1.0, 2.0, flooded && part.z < 0.5);
    return out;
}

@fragment
fn draped(in: Corner) -> @location(0) vec4<f32> {
    let color = textureSample(picture, soft, in.uv).rgb;
    let cut = mix(color, vec3<f32>(0.33, 0.29, 0.26), 0.8) * 0.75;
    let side = mix(cut, scene.water.rgb * 0.8, clamp(in.side - 1.0, 0.0, 1.0));
    return vec4<f32>(mix(color, side, min(in.side, 1.0)), 1.0);
}

struct Surface {
    @builtin(position) position: vec4<f32>,
    @location(0) sample: vec2<f32>,
}

// The water: one quad over the whole terrain.
@vertex
fn sea(@builtin(vertex_index) index: u32) -> Surface {
    let corner = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    var out: Surface;
    out.sample = corner * (scene.size.xy - 1.0);
    out.position = stand(out.sample, scene.size.z);
    return out;
}

@fragment
fn wet(in: Surface) -> @location(0) vec4<f32> {
    let depth = scene.size.z - height(vec2<i32>(in.sample));
    if depth <= 0.0 {
        discard;
    }
    // Shallow water shows the ground.
    let thick = 1.0 - exp(-depth / (scene.heights.z * 0.04 + 1.0));
    return vec4<f32>(scene.water.rgb, 0.45 + 0.5 * thick);
}
