//! The data that is uploaded to the device: heights, pictures, the corners of the walls.

use eframe::wgpu::{self, util::DeviceExt as _};

use super::pipeline::COLOR;
use crate::render::Picture;
use crate::value::Field;

/// The four cut sides of the block as one triangle strip; a corner is column, row, and 1 at the foot of the wall.
pub(super) fn walls(cols: u32, rows: u32) -> Vec<[f32; 3]> {
    let (c, r) = (cols - 1, rows - 1);
    let north = (0..=c).map(|i| [i, 0]);
    let east = (0..=r).map(|j| [c, j]);
    let south = (0..=c).rev().map(|i| [i, r]);
    let west = (0..=r).rev().map(|j| [0, j]);
    let around = north.chain(east).chain(south).chain(west);
    around.flat_map(|[i, j]| [[i as f32, j as f32, 0.0], [i as f32, j as f32, 1.0]]).collect()
}

pub(super) fn field_texture(device: &wgpu::Device, queue: &wgpu::Queue, field: &Field) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width: field.grid().cols as u32,
        height: field.grid().rows as u32,
        depth_or_array_layers: 1,
    };
    let descriptor = wgpu::TextureDescriptor {
        label: Some("heights"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let data = bytemuck::cast_slice(field.data());
    let texture = device.create_texture_with_data(queue, &descriptor, order, data);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The texture of a picture with its mip levels, so that far ground does not flicker.
pub(super) fn picture_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    picture: &Picture,
) -> wgpu::TextureView {
    let mut size = [picture.width.max(1), picture.height.max(1)];
    let mut level: Vec<[u8; 4]> = picture.rgb.iter().map(|c| [c[0], c[1], c[2], 255]).collect();
    let (mut data, mut levels) = (Vec::new(), 0);
    let first = size;
    loop {
        data.extend_from_slice(bytemuck::cast_slice(&level));
        levels += 1;
        if size == [1, 1] {
            break;
        }
        (level, size) = halved(&level, size);
    }
    let descriptor = wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width: first[0] as u32, height: first[1] as u32, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: COLOR,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = device.create_texture_with_data(queue, &descriptor, order, &data);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn halved(from: &[[u8; 4]], [w, h]: [usize; 2]) -> (Vec<[u8; 4]>, [usize; 2]) {
    let size = [(w / 2).max(1), (h / 2).max(1)];
    let mut out = Vec::with_capacity(size[0] * size[1]);
    for j in 0..size[1] {
        for i in 0..size[0] {
            let at = |di: usize, dj: usize| from[(2 * j + dj).min(h - 1) * w + (2 * i + di).min(w - 1)];
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            out.push(std::array::from_fn(|k| {
                let sum: u32 = four.iter().map(|c| u32::from(c[k])).sum();
                ((sum + 2) / 4) as u8
            }));
        }
    }
    (out, size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_go_once_around() {
        let corners = walls(3, 2);
        assert_eq!(corners.len(), 2 * (3 + 2 + 3 + 2));
        assert_eq!(corners.first(), Some(&[0.0, 0.0, 0.0]));
        assert_eq!(corners.last(), Some(&[0.0, 0.0, 1.0]));
    }

    #[test]
    fn smaller_pictures_keep_the_mean() {
        let (one, size) = halved(&[[0, 8, 0, 255], [4, 8, 0, 255]], [2, 1]);
        assert_eq!((one, size), (vec![[2, 8, 0, 255]], [1, 1]));
    }
}
