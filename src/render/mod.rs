//! Shaded pictures of terrain, on the CPU.
