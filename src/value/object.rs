//! Values on wires that are no rasters: curves, constraints, and whatever else a node makes.
//!
//! A type says of itself here what engine, cache, pictures and editor want to know, so that a new one needs its own file
//! and the ports that carry it, and nothing else.

use std::any::Any;
use std::cmp::Ordering;
use std::fmt::{self, Debug};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use super::{Features, Grid, Value};

/// Reads an object from a file of the cache.
pub type ObjectLoader = fn(&[u8]) -> Option<Value>;

/// What a type of objects is to ports, pages and the canvas.
#[derive(Debug)]
pub struct ObjectType {
    /// Name in messages and pages, unique among all wire types.
    pub name: &'static str,
    /// Colour of its wires, sRGB.
    pub color: [u8; 3],
    /// The form of its pins.
    pub pin: Pin,
    /// Bytes of one sample, at most, of what stands on a grid; 0 for what stands on none.
    pub sample_bytes: u64,
    /// Bytes that a value without samples is taken to hold before it is there; 0 for what has samples.
    pub guessed_bytes: u64,
    /// Reads what [`Object::save`] wrote, and nothing that has a fault. None where a cache folder does not keep it, since
    /// reading would take longer than making.
    pub load: Option<ObjectLoader>,
    /// Whether its values are lines, which [`Object::features`] gives and files of vectors hold.
    pub has_features: bool,
}

/// The form of a pin, so that wires are told apart without their colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pin {
    /// A circle.
    Circle,
    /// A regular polygon.
    Polygon {
        /// Its corners.
        corners: u8,
        /// How far it is turned, in shares of the angle between two corners.
        turn: f32,
    },
}

/// A value that travels on wires and is no raster. Clones share what they hold.
pub trait Object: Clone + Debug + PartialEq + Send + Sync + 'static {
    /// What the type is to ports, pages and the canvas.
    const TYPE: &'static ObjectType;

    /// Bytes in memory.
    fn bytes(&self) -> u64;

    /// Where its samples stand, if it has some.
    fn grid(&self) -> Option<&Grid> {
        None
    }

    /// What is wrong with it, without a subject: the engine accepts no such result (law 8), and no such file of a cache.
    fn fault(&self) -> Option<String>;

    /// How it is drawn in thumbnails and on the map.
    fn sketch(&self) -> Sketch;

    /// What it says of a place of the world, for the pointer on the map.
    fn say(&self, at: [f64; 2]) -> Option<String> {
        let _ = at;
        None
    }

    /// Its form in a file of the cache, where [`ObjectType::load`] reads one.
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Its lines for a file of vectors, where [`ObjectType::has_features`].
    fn features(&self) -> Features<'_> {
        Box::new(std::iter::empty())
    }
}

/// What is drawn of an object.
#[derive(Clone, Debug, PartialEq)]
pub enum Sketch {
    /// Lines in the world.
    Lines(Vec<SketchLine>),
    /// Marks of the samples of a grid, row by row.
    Marks(Grid, Vec<SketchMark>),
}

/// A place of a sketch in metres, x east and y south, and its height where it has one.
pub type SketchPoint = ([f64; 2], Option<f64>);
/// A line of a sketch.
pub type SketchLine = Vec<SketchPoint>;

/// What is drawn of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SketchMark {
    /// Nothing is said of it.
    Nothing,
    /// A height, in metres.
    Height(f32),
    /// Something of weight.
    Strong,
    /// Something of less weight.
    Weak,
}

/// An object with its type erased; cheap to clone.
#[derive(Clone)]
pub struct AnyObject(Arc<dyn Erased>);

trait Erased: Debug + Send + Sync {
    fn wire(&self) -> &'static ObjectType;
    fn bytes(&self) -> u64;
    fn grid(&self) -> Option<&Grid>;
    fn fault(&self) -> Option<String>;
    fn sketch(&self) -> Sketch;
    fn say(&self, at: [f64; 2]) -> Option<String>;
    fn save(&self) -> Vec<u8>;
    fn features(&self) -> Features<'_>;
    fn same(&self, other: &dyn Any) -> bool;
    fn any(&self) -> &dyn Any;
}

impl<T: Object> Erased for T {
    fn wire(&self) -> &'static ObjectType {
        T::TYPE
    }
    fn bytes(&self) -> u64 {
        Object::bytes(self)
    }
    fn grid(&self) -> Option<&Grid> {
        Object::grid(self)
    }
    fn fault(&self) -> Option<String> {
        Object::fault(self)
    }
    fn sketch(&self) -> Sketch {
        Object::sketch(self)
    }
    fn say(&self, at: [f64; 2]) -> Option<String> {
        Object::say(self, at)
    }
    fn save(&self) -> Vec<u8> {
        Object::save(self)
    }
    fn features(&self) -> Features<'_> {
        Object::features(self)
    }
    fn same(&self, other: &dyn Any) -> bool {
        other.downcast_ref::<T>() == Some(self)
    }
    fn any(&self) -> &dyn Any {
        self
    }
}

impl AnyObject {
    /// Its type.
    pub fn wire(&self) -> &'static ObjectType {
        self.0.wire()
    }

    /// The object, where it is of a type.
    pub fn get<T: Object>(&self) -> Option<&T> {
        self.0.any().downcast_ref()
    }

    /// See [`Object::bytes`].
    pub fn bytes(&self) -> u64 {
        self.0.bytes()
    }

    /// See [`Object::grid`].
    pub fn grid(&self) -> Option<&Grid> {
        self.0.grid()
    }

    /// See [`Object::fault`].
    pub fn fault(&self) -> Option<String> {
        self.0.fault()
    }

    /// See [`Object::sketch`].
    pub fn sketch(&self) -> Sketch {
        self.0.sketch()
    }

    /// See [`Object::say`].
    pub fn say(&self, at: [f64; 2]) -> Option<String> {
        self.0.say(at)
    }

    /// See [`Object::save`].
    pub fn save(&self) -> Vec<u8> {
        self.0.save()
    }

    /// See [`Object::features`].
    pub fn features(&self) -> Features<'_> {
        self.0.features()
    }
}

impl<T: Object> From<T> for AnyObject {
    fn from(object: T) -> Self {
        Self(Arc::new(object))
    }
}

impl<T: Object> From<T> for Value {
    fn from(object: T) -> Self {
        Self::Object(object.into())
    }
}

impl PartialEq for AnyObject {
    fn eq(&self, other: &Self) -> bool {
        self.0.same(other.0.any())
    }
}

impl Debug for AnyObject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

// Types are told apart by name.
impl PartialEq for ObjectType {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for ObjectType {}

impl Hash for ObjectType {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}

impl PartialOrd for ObjectType {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for ObjectType {
    fn cmp(&self, other: &Self) -> Ordering {
        self.name.cmp(other.name)
    }
}
