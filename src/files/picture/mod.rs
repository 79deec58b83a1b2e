//! Pictures that hold colours: PNG, JPEG, WebP, BMP, TGA and the merged image of a PSD.
//!
//! [`PictureClaim::of`] tells from a header what a picture will take, [`Picture::read`] reads it, and [`Texture`] gives
//! colours and a mask at any place, averaged over as much of the picture as a sample stands for.
//!
//! Components are sRGB encoded, as the colours of a graph are; profiles that a file brings are not looked at. Decoders
//! run without the instructions that only some machines have, so that a picture has the same bits everywhere.

mod claim;
mod decode;
mod psd;
mod texture;

pub use claim::{PictureClaim, PictureKind};
pub use decode::Picture;
pub use texture::{Channel, Kernel, Mixture, PixelSpan, Texture, TextureColumns};
