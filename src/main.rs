//! The `orograph` program: hands over to the command line.

fn main() -> std::process::ExitCode {
    orograph::cli::main()
}
