//! What a budget means: every preset run by the program itself, what it planned beside what the process took.
//!
//! `cargo bench --bench budgets` prints the table of docs/budgets.md and says at the end what misses a bar. Arguments
//! narrow it down: names of presets (or of the cases `render`, `base`, `chain`), `--sizes 513,tiles`,
//! `--budgets default,least`, `--threads N`; `--program FILE` measures another build of the program. The whole table
//! takes most of an hour on two cores.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use orograph::files::{Format, WriteJob, encode};
use orograph::render::map_cost;
use orograph::value::{Field, Quantity, Terrain, Value};
use serde_json::{Map, Value as Json, json};

const MIB: f64 = 1024.0 * 1024.0;
/// The process may take this many times the bytes that are planned for nodes, document and writers, beside the idle
/// program.
const OVER: f64 = 1.25;
/// Above so many MiB the plan must not be more than [`UNDER`] times what was used.
const LARGE: f64 = 200.0;
const UNDER: f64 = 2.0;
/// Processor seconds by planned seconds.
const SECONDS: [f64; 2] = [0.5, 2.0];
/// What takes less is the start of the program, and the clock's ticks.
const SHORT: f64 = 0.3;

fn main() {
    let asked = Asked::new(std::env::args().skip(1));
    let scratch = Scratch::new();
    let idle = scratch.idle(&asked);
    println!("The idle program: {:.0} MiB, {} threads.\n", idle.process, asked.threads);
    println!(
        "| what | size | budget, MiB | planned, MiB | account, MiB | process, MiB | process / bar | planned / used | \
         planned, s | processor, s | ratio | misses |"
    );
    println!("|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|:--|");
    let mut missed = 0;
    for case in asked.cases(&scratch) {
        for least in [false, true].into_iter().filter(|least| asked.budget(*least)) {
            let row = case.run(&scratch, &asked, least);
            let misses = row.misses(&idle);
            missed += misses.len();
            println!("{}", row.line(&idle, &misses));
        }
    }
    println!("\n{missed} bars missed.");
}

/// What the command line asked for.
struct Asked {
    names: Vec<String>,
    sizes: Vec<String>,
    budgets: Vec<String>,
    threads: String,
    program: String,
}

impl Asked {
    fn new(arguments: impl Iterator<Item = String>) -> Self {
        let list = |text: &str| text.split(',').map(str::to_owned).collect::<Vec<_>>();
        let (sizes, budgets) = (list("513,1025,2049,4097,tiles"), list("default,least"));
        let program = env!("CARGO_BIN_EXE_orograph").to_owned();
        let mut asked = Self { names: Vec::new(), sizes, budgets, threads: "2".into(), program };
        // `cargo bench` adds an argument of its own.
        let mut arguments = arguments.filter(|a| a != "--bench");
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().unwrap_or_else(|| panic!("{argument} needs a value"));
            match argument.as_str() {
                "--sizes" => asked.sizes = list(&value()),
                "--budgets" => asked.budgets = list(&value()),
                "--threads" => asked.threads = value(),
                "--program" => asked.program = value(),
                _ => asked.names.push(argument),
            }
        }
        asked
    }

    fn named(&self, name: &str) -> bool {
        self.names.is_empty() || self.names.iter().any(|n| n == name)
    }

    fn budget(&self, least: bool) -> bool {
        self.budgets.iter().any(|b| b == if least { "least" } else { "default" })
    }

    fn cases(&self, scratch: &Scratch) -> Vec<Case> {
        let mut cases = Vec::new();
        for path in presets() {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let mut case = Case { name, graph: path, ..Case::default() };
            if case.name == "real_terrain" {
                case.set = vec!["--set".into(), format!("file={}", scratch.heights().display())];
            }
            for size in self.sizes.iter().filter(|_| self.named(&case.name)) {
                let tiles: &[&str] = &["--size", "8193", "--tile-size", "1025", "--tile", "3,4"];
                let options = if size == "tiles" { tiles } else { &["--size", size] };
                cases.push(case.with(size, options));
            }
        }
        let graph = |name: &str| root().join("graphs").join(format!("{name}.graph"));
        let mountain = Case { graph: graph("mountain"), ..Case::default() };
        if self.named("base") {
            let base = ["--size", "2049", "--base", "2049"];
            cases.push(Case { name: "mountain, base 2049".into(), ..mountain.with("2049", &base) });
        }
        if self.named("chain") {
            let chain = Case { graph: scratch.chain(19_999), ..Case::default() };
            cases.push(Case { name: "19_999 `clamp`".into(), ..chain.with("129", &["--size", "129"]) });
        }
        if self.named("render") {
            let size = ["--size", "2049"];
            cases.push(Case { name: "render mountain".into(), render: true, ..mountain.with("2049", &size) });
        }
        cases
    }
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn presets() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("graphs")).expect("the presets").flatten().map(|e| e.path());
    let mut graphs: Vec<_> = entries.filter(|p| p.extension().is_some_and(|e| e == "graph")).collect();
    graphs.sort();
    graphs
}

/// A folder for what is built, gone at the end.
struct Scratch(tempfile::TempDir);

impl Scratch {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a scratch folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// What the program takes to build next to nothing.
    fn idle(&self, asked: &Asked) -> Row {
        let graph = root().join("graphs/first_light.graph");
        let case = Case { graph, ..Case::default() };
        case.with("17", &["--size", "17", "--base", "17"]).run(self, asked, false)
    }

    /// Heights of some 20 km in 1201² samples, as an elevation model has them.
    fn heights(&self) -> PathBuf {
        let path = self.path("heights.tif");
        if !path.exists() {
            let terrain = Terrain { width: 20_000.0, depth: 20_000.0, ..Terrain::default() };
            let grid = terrain.grid(1201).expect("a grid");
            let wave = |x: f64, y: f64| {
                libm::sin(x / 900.0) * libm::cos(y / 1300.0) + libm::sin((x + y) / 170.0) / 9.0
            };
            let field = Field::from_fn(grid, Quantity::Elevation, |x, y| (900.0 + 500.0 * wave(x, y)) as f32);
            let value = Value::Field(field);
            let mut file = fs::File::create(&path).expect("a file");
            encode(&WriteJob::new(&value, Format::Tiff, &terrain, grid), &mut file).expect("heights");
        }
        path
    }

    /// A graph of a noise and so many clamps, one after the other.
    fn chain(&self, length: usize) -> PathBuf {
        let path = self.path("chain.graph");
        let mut nodes = Map::new();
        nodes.insert("n0".into(), json!({ "kind": "fractal_noise" }));
        for i in 1..=length {
            let input = json!({ "field": format!("n{}.field", i - 1) });
            nodes.insert(format!("n{i}"), json!({ "kind": "clamp", "in": input }));
        }
        let outputs = json!({ "height": { "from": format!("n{length}.field"), "format": "exr" } });
        let graph = json!({ "orograph": 1, "nodes": nodes, "outputs": outputs });
        fs::write(&path, graph.to_string()).expect("a graph");
        path
    }
}

/// Something to run.
#[derive(Clone, Default)]
struct Case {
    name: String,
    graph: PathBuf,
    size: String,
    set: Vec<String>,
    options: Vec<String>,
    render: bool,
}

impl Case {
    fn with(&self, size: &str, options: &[&str]) -> Self {
        let options = options.iter().map(|o| (*o).to_owned()).collect();
        Self { size: size.to_owned(), options, ..self.clone() }
    }

    fn program(&self, command: &str, asked: &Asked, more: &[&str]) -> Output {
        let mut program = Command::new(&asked.program);
        program.arg(command).arg(&self.graph).args(&self.set).args(&self.options);
        program.args(["--threads", &asked.threads]).args(more).output().expect("the program")
    }

    fn run(&self, scratch: &Scratch, asked: &Asked, least: bool) -> Row {
        let budget = least.then(|| self.least(scratch, asked));
        let memory = budget.map(|mib| format!("{mib}M"));
        let memory: Vec<&str> = memory.iter().flat_map(|m| ["--memory", m]).collect();
        let out = scratch.path("out");
        let _ = fs::remove_dir_all(&out);
        let mut row = Row { what: self.name.clone(), size: self.size.clone(), budget, ..Row::default() };
        let taken = if self.render {
            let picture = scratch.path("picture.png").display().to_string();
            self.measured("render", asked, &[&["-o", &picture], &memory[..]].concat())
        } else {
            let out = out.display().to_string();
            self.measured("build", asked, &[&["-o", &out], &memory[..]].concat())
        };
        if !taken.0.status.success() {
            let said = String::from_utf8_lossy(&taken.0.stderr).into_owned();
            row.failed = Some(said.lines().last().unwrap_or("failed").to_owned());
            return row;
        }
        let report = fs::read(out.join("report.json")).ok().and_then(|b| serde_json::from_slice(&b).ok());
        let report: Json = report.unwrap_or_default();
        let number = |name: &str| report[name].as_f64().unwrap_or(f64::NAN);
        row.planned = number("planned_bytes") / MIB;
        row.reserve = number("reserve_bytes") / MIB;
        row.account = number("peak_bytes") / MIB;
        row.planned_seconds = number("planned_seconds");
        (row.process, row.seconds) = (taken.1, taken.2);
        if self.render {
            let plan = self.program("plan", asked, &["--json"]);
            let plan: Json = serde_json::from_slice(&plan.stdout).unwrap_or_default();
            let size: usize = self.size.parse().expect("columns");
            let drawing = map_cost([size, size], None, true);
            row.planned = (plan["peak_bytes"].as_f64().unwrap_or(f64::NAN) + drawing.bytes as f64) / MIB;
            row.planned_seconds = plan["seconds"].as_f64().unwrap_or(f64::NAN) + drawing.seconds;
        }
        row
    }

    /// Runs the program under GNU time: its output, the most MiB it held, its processor seconds.
    fn measured(&self, command: &str, asked: &Asked, more: &[&str]) -> (Output, f64, f64) {
        let mut time = Command::new("/usr/bin/time");
        time.args(["-q", "-f", "%M %U %S", &asked.program, command]).arg(&self.graph).args(&self.set);
        time.args(&self.options).args(["--threads", &asked.threads]).args(more);
        let output = time.output().expect("GNU time");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let numbers: Vec<f64> =
            said.lines().last().unwrap_or_default().split(' ').filter_map(|n| n.parse().ok()).collect();
        match numbers[..] {
            [kib, user, system] => (output, kib / 1024.0, user + system),
            _ => (output, f64::NAN, f64::NAN),
        }
    }

    /// The least whole number of MiB that is not refused.
    fn least(&self, scratch: &Scratch, asked: &Asked) -> u64 {
        let (command, out) = if self.render { ("render", "refused.png") } else { ("build", "refused") };
        let out = scratch.path(out).display().to_string();
        // What is not refused is stopped by its budget of time, which is looked at after that of memory.
        let needed = |mib: u64| -> bool {
            let memory = format!("{mib}M");
            let output = self.program(command, asked, &["-o", &out, "--memory", &memory, "--time", "1e-9"]);
            !String::from_utf8_lossy(&output.stderr).contains("--time")
        };
        let (mut refused, mut taken) = (1, 1 << 17);
        while taken - refused > 1 {
            let middle = u64::midpoint(refused, taken);
            if needed(middle) {
                refused = middle;
            } else {
                taken = middle;
            }
        }
        taken
    }
}

/// What was planned and what was taken; bytes in MiB.
#[derive(Default)]
struct Row {
    what: String,
    size: String,
    budget: Option<u64>,
    /// For the nodes.
    planned: f64,
    /// For the program, the document and the writers.
    reserve: f64,
    account: f64,
    process: f64,
    planned_seconds: f64,
    seconds: f64,
    failed: Option<String>,
}

impl Row {
    /// What is planned beside the idle program: nodes, document, writers.
    fn plan(&self, idle: &Self) -> f64 {
        self.planned + (self.reserve - idle.reserve).max(0.0)
    }

    fn bar(&self, idle: &Self) -> f64 {
        OVER * self.plan(idle) + idle.process
    }

    fn used(&self, idle: &Self) -> f64 {
        (self.process - idle.process).max(1.0)
    }

    /// The names of the bars that are missed.
    fn misses(&self, idle: &Self) -> Vec<&'static str> {
        let over = |bad: bool, name| bad.then_some(name);
        let ratio = self.seconds / self.planned_seconds;
        let long = self.seconds.max(self.planned_seconds) > SHORT;
        [
            over(self.failed.is_some(), "failed"),
            over(self.budget.is_some_and(|b| self.process > b as f64), "budget"),
            over(self.process > self.bar(idle), "plan"),
            over(self.account > self.planned, "account"),
            over(self.plan(idle) > LARGE && self.plan(idle) > UNDER * self.used(idle), "too much planned"),
            over(long && !(SECONDS[0]..=SECONDS[1]).contains(&ratio), "seconds"),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn line(&self, idle: &Self, misses: &[&str]) -> String {
        if let Some(failed) = &self.failed {
            return format!("| {} | {} | {failed} |", self.what, self.size);
        }
        let budget = self.budget.map_or_else(|| "default".to_owned(), |b| b.to_string());
        let mut line = format!("| {} | {} | {budget} ", self.what, self.size);
        for mib in [self.plan(idle), self.account, self.process] {
            let _ = write!(line, "| {mib:.0} ");
        }
        let _ = write!(
            line,
            "| {:.2} | {:.2} ",
            self.process / self.bar(idle),
            self.plan(idle) / self.used(idle)
        );
        let _ = write!(line, "| {:.2} | {:.2} ", self.planned_seconds, self.seconds);
        let _ = write!(line, "| {:.2} | {} |", self.seconds / self.planned_seconds, misses.join(", "));
        line
    }
}
