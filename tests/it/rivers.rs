//! From river networks to land, and blocks of land set into other land.

mod blend;
mod carve;
mod enrich;
mod land;
mod poisson;
mod presets;
mod skeleton;
