//! What a user waits for: writing and reading height files.

fn main() {
    divan::main();
}
