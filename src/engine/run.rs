//! Runs the tasks of a plan: independent ones side by side, within the budget of memory.
//!
//! Tasks start in order. The first that is not done may always run: the estimate of the peak is that of running in
//! order. Others start ahead of it only while what they hold fits beside what the tasks before them will, so the account
//! never goes over the estimate and never comes to a standstill.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use rayon::Scope;

use super::cache::{Found, Given, Store, Warnings};
use super::error::{Failure, SharedFailure};
use super::outputs::Outputs;
use super::plan::{Plan, Role, Stage, Task};
use super::program::{Input, Step};
use super::{Keep, lift, mix};
use crate::name::Name;
use crate::node::{Cancel, Context, Detail, Error, Kind, Result};
use crate::ports::{MASK, Wires};
use crate::value::{Grid, Quantity, Value};
use crate::work::Work;

/// What happens while an evaluation runs; called from several threads.
pub trait Observer: Sync {
    /// The content of a file that a node names is read to know what it holds: the finished share, 0 to 1.
    fn reading(&self, node: &str, file: &str, share: f32) {
        let _ = (node, file, share);
    }
    /// The plan is made and admitted; tasks are numbered by their place in it.
    fn planned(&self, plan: &Plan) {
        let _ = plan;
    }
    /// A task starts.
    fn started(&self, task: usize) {
        let _ = task;
    }
    /// The finished share of a task, 0 to 1.
    fn progress(&self, task: usize, share: f32) {
        let _ = (task, share);
    }
    /// A task is done or has failed.
    fn finished(&self, task: usize, seconds: f64) {
        let _ = (task, seconds);
    }
}

/// Nobody looks.
#[derive(Clone, Copy, Debug)]
pub struct Unobserved;

impl Observer for Unobserved {}

/// What a task did.
#[derive(Clone, Debug)]
pub struct TaskReport {
    /// Name of the node.
    pub node: String,
    /// Its kind.
    pub kind: Name,
    /// What the task did.
    pub stage: Stage,
    /// The grid it ran on; none for a gridless node.
    pub grid: Option<Grid>,
    /// Where the cache had the result: `memory`, `disk`, or not.
    pub cached: Option<&'static str>,
    /// Seconds it took.
    pub seconds: f64,
    /// Bytes of its outputs.
    pub bytes: u64,
    /// What the node said of its result, also where memory had it, sorted. A result that somebody warned of is written
    /// to no file, so that the next process hears it, too; a node whose consumers all were cached is not asked.
    pub warnings: Vec<String>,
    /// Whether it ended with a result.
    pub done: bool,
}

/// The end of a task: what it gives, or what failed.
type End = Result<Arc<Given>, SharedFailure>;

/// What the tasks of a plan gave.
pub(super) struct Ran {
    pub wanted: Vec<Result<Arc<Given>, SharedFailure>>,
    pub reports: Vec<TaskReport>,
    /// A file of the cache that the plan counted on could not be used.
    pub lost: bool,
    /// Most bytes that were alive at once, by account.
    pub peak_bytes: u64,
}

pub(super) struct Runner<'a> {
    pub plan: &'a Plan,
    /// Results of the plan that were in memory, by task.
    pub held: Vec<Option<(Given, Warnings)>>,
    pub store: &'a Store,
    pub keep: Keep,
    pub pool: &'a rayon::ThreadPool,
    pub observer: &'a dyn Observer,
    pub cancel: &'a Cancel,
    /// Most bytes that may be alive at once, by account: the peak of the plan, or more.
    pub limit: u64,
}

/// How far beyond the first task that is not done others are looked for: enough for any number of threads, and little
/// work where thousands are ready.
const LOOK_AHEAD: usize = 1024;

struct State {
    ends: Vec<Option<End>>,
    /// Needs of each task that are not done.
    missing: Vec<usize>,
    /// Tasks whose needs are done and that have not started.
    ready: BTreeSet<usize>,
    /// Tasks that run; more than there are threads would only hold memory.
    running: usize,
    /// The first task that is not done.
    first: usize,
    uses: Vec<usize>,
    reports: BTreeMap<usize, TaskReport>,
    /// Bytes that tasks beyond the first unfinished one hold.
    ahead: BTreeMap<usize, u64>,
    held: Vec<Option<(Given, Warnings)>>,
    alive: u64,
    peak: u64,
    lost: bool,
}

impl State {
    fn new(plan: &Plan, held: Vec<Option<(Given, Warnings)>>) -> Self {
        let n = plan.tasks.len();
        let missing: Vec<usize> = plan.tasks.iter().map(|t| t.needs.len()).collect();
        Self {
            ends: vec![None; n],
            ready: (0..n).filter(|i| missing[*i] == 0).collect(),
            missing,
            running: 0,
            first: 0,
            uses: plan.uses(),
            reports: BTreeMap::new(),
            ahead: BTreeMap::new(),
            held,
            alive: plan.standing_bytes(),
            peak: plan.standing_bytes(),
            lost: false,
        }
    }

    /// Enters a task as started and hands over what it needs.
    fn start(&mut self, i: usize, task: &Task) -> Vec<Option<End>> {
        self.ready.remove(&i);
        self.running += 1;
        if i > self.first {
            self.ahead.insert(i, task.bytes());
        }
        self.alive += task.bytes();
        self.peak = self.peak.max(self.alive);
        task.needs.iter().map(|(_, t)| self.ends[*t].clone()).collect()
    }
}

impl Runner<'_> {
    pub(super) fn run(mut self) -> Ran {
        let consumers = self.plan.consumers();
        let state = Mutex::new(State::new(self.plan, std::mem::take(&mut self.held)));
        self.pool.in_place_scope(|scope| self.launch(scope, &state, &consumers));
        let state = state.into_inner().unwrap_or_else(PoisonError::into_inner);
        let stopped = || Arc::new(Failure::Cancelled);
        let end = |w: &Result<usize, SharedFailure>| match w {
            Ok(task) => state.ends[*task].clone().unwrap_or_else(|| Err(stopped())),
            Err(failure) => Err(failure.clone()),
        };
        let wanted = self.plan.wanted.iter().map(end).collect();
        Ran {
            wanted,
            reports: state.reports.into_values().collect(),
            lost: state.lost,
            peak_bytes: state.peak,
        }
    }

    /// Starts every task that is ready and may start; each, when it ends, starts those that waited for it.
    fn launch<'s>(&'s self, scope: &Scope<'s>, state: &'s Mutex<State>, consumers: &'s [Vec<usize>]) {
        let lock = || state.lock().unwrap_or_else(PoisonError::into_inner);
        let mut guard = lock();
        while let Some(i) = self.next(&guard) {
            let task = &self.plan.tasks[i];
            let given = guard.start(i, task);
            let held = guard.held[i].take();
            scope.spawn(move |scope| {
                let (end, report, lost) = self.execute(i, task, held, &given);
                drop(given);
                let mut guard = lock();
                guard.lost |= lost;
                self.settle(&mut guard, i, task, end, report);
                for &consumer in &consumers[i] {
                    guard.missing[consumer] -= 1;
                    if guard.missing[consumer] == 0 {
                        guard.ready.insert(consumer);
                    }
                }
                drop(guard);
                self.launch(scope, state, consumers);
            });
        }
    }

    /// The first task that is ready and may start.
    fn next(&self, state: &State) -> Option<usize> {
        let threads = self.pool.current_num_threads();
        if self.cancel.is_cancelled() || state.lost || state.running >= threads {
            return None;
        }
        let first = state.ready.first().copied()?;
        if first == state.first {
            return Some(first);
        }
        let (course, tasks) = (&self.plan.peak.course, &self.plan.tasks);
        let ahead: u64 = state.ahead.values().sum();
        // What the tasks up to there hold at most while they run in their order, with what is ahead already.
        let reached = state.ahead.last_key_value().map_or(state.first, |(last, _)| *last);
        let mut before = course[state.first..=reached].iter().copied().max().unwrap_or(0);
        let mut next = reached + 1;
        for &i in state.ready.range(..state.first.saturating_add(LOOK_AHEAD)) {
            while next <= i {
                before = before.max(course[next]);
                next += 1;
            }
            if before.saturating_add(ahead) > self.limit {
                return None;
            }
            if before.saturating_add(ahead).saturating_add(tasks[i].bytes()) <= self.limit {
                return Some(i);
            }
        }
        None
    }

    /// Enters the end of a task and lets go of what nobody needs any more.
    fn settle(&self, state: &mut State, i: usize, task: &Task, end: End, report: TaskReport) {
        state.running -= 1;
        state.alive = state.alive.saturating_sub(task.scratch_bytes());
        if let Some(ahead) = state.ahead.get_mut(&i) {
            *ahead = ahead.saturating_sub(task.scratch_bytes());
        }
        let released = task.needs.iter().map(|(_, need)| *need).chain((state.uses[i] == 0).then_some(i));
        let released: Vec<usize> = released.collect();
        state.ends[i] = Some(end);
        state.reports.insert(i, report);
        for t in released {
            state.uses[t] = state.uses[t].saturating_sub(1);
            if state.uses[t] == 0 {
                state.alive = state.alive.saturating_sub(self.plan.tasks[t].released_bytes());
                // The end stays marked as done; the values go.
                if let Some(Ok(given)) = &mut state.ends[t] {
                    *given = Arc::new(Given::Wires(Wires::default()));
                }
            }
        }
        while state.ends.get(state.first).is_some_and(Option::is_some) {
            state.first += 1;
        }
        state.ahead = state.ahead.split_off(&state.first);
    }

    fn execute(
        &self,
        i: usize,
        task: &Task,
        held: Option<(Given, Warnings)>,
        needs: &[Option<End>],
    ) -> (End, TaskReport, bool) {
        let step = self.plan.step(task);
        let start = Instant::now();
        self.observer.started(i);
        let mut lost = false;
        let mut warnings = Warnings::default();
        let end = match inputs(needs) {
            Err(failure) => Err(failure),
            Ok(given) => match (&task.found, held) {
                (Some(Found::Memory(..)), Some((given, said))) => {
                    warnings = said;
                    Ok(Arc::new(given))
                }
                (Some(Found::Disk(path)), _) => match self.load(path, task, &step.kind) {
                    Ok(given) => Ok(self.kept(task, &step.kind, given, &warnings)),
                    Err(why) => {
                        lost = true;
                        Err(Arc::new(Failure::Cache(format!("{why}: {}", path.display()))))
                    }
                },
                _ => self
                    .compute(i, task, &given, &mut warnings)
                    .map_err(|error| Arc::new(Failure::of_run(step.name(), error))),
            },
        };
        let seconds = start.elapsed().as_secs_f64();
        self.observer.finished(i, seconds);
        let report = TaskReport {
            node: step.name().to_owned(),
            kind: step.kind.id.clone(),
            stage: task.stage,
            grid: task.grid(),
            cached: task.found.as_ref().map(Found::place),
            seconds,
            bytes: end.as_ref().map_or(0, |g| g.bytes()),
            warnings: warnings.to_vec(),
            done: end.is_ok(),
        };
        (end, report, lost)
    }

    /// A result from the cache folder.
    fn load(&self, path: &Path, task: &Task, kind: &Kind) -> io::Result<Given> {
        let (Some(disk), Some(key)) = (&self.store.disk, task.key) else {
            return Err(io::ErrorKind::NotFound.into());
        };
        disk.get(path, &key, &task.grid, kind)
    }

    fn compute(
        &self,
        i: usize,
        task: &Task,
        given: &[Arc<Given>],
        warnings: &mut Warnings,
    ) -> Result<Arc<Given>> {
        self.cancel.check()?;
        let step = self.plan.step(task);
        let needs: Vec<_> = task.needs.iter().map(|(role, _)| *role).zip(given).collect();
        let summary = needs.iter().find_map(|(role, g)| match (role, &***g) {
            (Role::Summary, Given::Summary(s)) => Some(s),
            _ => None,
        });
        let views = views(step, &needs)?;
        // Progress arrives from many threads; only steps of a hundredth go on.
        let last = AtomicU64::new(0);
        let progress = |share: f32| {
            let now = (f64::from(share) * 100.0) as u64;
            if last.fetch_max(now, Ordering::Relaxed) < now {
                self.observer.progress(i, share);
            }
        };
        // From any thread, in any order, and perhaps the same twice.
        let said = Mutex::new(BTreeSet::new());
        let warn = |message: String| {
            said.lock().unwrap_or_else(PoisonError::into_inner).insert(message);
        };
        let cx = Context {
            grid: task.grid,
            reads: step.kind.reads,
            world: &self.plan.program.terrain,
            whole: summary,
            views: &views,
            files: &step.files,
            work: Work::new(self.cancel).telling(&progress).warning(&warn),
        };
        let work = || stage(&cx, task, step, &needs);
        let given = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(panicked(&*panic)));
        *warnings = said.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect();
        let given = given?;
        // A file holds no warnings, and what a quick kind gives is made sooner than read.
        let lasts = given.is_kept() && warnings.is_empty() && !step.kind.quick;
        let disk = self.store.disk.as_ref().filter(|_| lasts);
        if let Some((disk, key)) = disk.zip(task.key) {
            disk.put(&key, &task.grid, &given);
        }
        Ok(self.kept(task, &step.kind, given, warnings))
    }

    /// What of a result goes on to its readers; the store has its share.
    fn kept(&self, task: &Task, kind: &Kind, given: Given, warnings: &Warnings) -> Arc<Given> {
        if self.keep == Keep::Everything
            && let Some(key) = task.key
        {
            self.store.keep(key, task.grid, &given, warnings);
        }
        let read = given.only(kind, task.read);
        if self.keep == Keep::Lasting
            && task.lasting
            && let Some(key) = task.key
        {
            self.store.keep(key, task.grid, &read, warnings);
        }
        Arc::new(read)
    }
}

fn panicked(panic: &(dyn std::any::Any + Send)) -> Error {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let message =
        text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into());
    Error::Panic { message }
}

/// The results of all needs, or the first failure among them.
fn inputs(needs: &[Option<End>]) -> Result<Vec<Arc<Given>>, SharedFailure> {
    let missing = || Arc::new(Failure::Engine("an input was not computed".into()));
    needs.iter().map(|n| n.clone().unwrap_or_else(|| Err(missing()))).collect()
}

type Needs<'a> = [(Role, &'a Arc<Given>)];

fn stage(cx: &Context<'_>, task: &Task, step: &Step, needs: &Needs<'_>) -> Result<Given> {
    let (node, kind) = (&step.node, &*step.kind);
    let mut own = Wires::default();
    for (role, given) in needs {
        if let (Role::Input(i), Some(wires)) = (role, given.wires()) {
            put(&mut own, &step.inputs[*i], wires)?;
        }
    }
    let mut out = match task.stage {
        Stage::Summary => return node.summarize(cx, own).map(Given::Summary),
        Stage::Gridless | Stage::Base | Stage::Run => node.run(cx, own)?,
        Stage::Lift => lifted(cx, step, task.read, needs)?,
    };
    let made = if task.stage == Stage::Lift { task.read } else { Outputs::all(kind) };
    check(&task.grid, step, made, &out)?;
    if !matches!(task.stage, Stage::Gridless | Stage::Base) && !kind.mixes.is_empty() {
        let fine = fine_inputs(step, needs)?;
        if let Some(Value::Field(mask)) = fine.get(&MASK.name) {
            mix::mix(cx, &kind.mixes, &fine, mask, &mut out)?;
        }
    }
    Ok(Given::Wires(out))
}

fn put(wires: &mut Wires, input: &Input, given: &Wires) -> Result<()> {
    wires.put(input.port.clone(), read(input, given)?.clone());
    Ok(())
}

/// What an input reads of the values that its step gave.
fn read<'a>(input: &Input, given: &'a Wires) -> Result<&'a Value> {
    given.get(&input.from).ok_or_else(|| Error::Missing { port: input.port.clone() })
}

/// The inputs on their further windows.
fn views(step: &Step, needs: &Needs<'_>) -> Result<Vec<(Name, Value)>> {
    let mut views = Vec::new();
    for (role, given) in needs {
        if let (Role::View(i), Some(wires)) = (role, given.wires()) {
            let input = &step.inputs[*i];
            views.push((input.port.clone(), read(input, wires)?.clone()));
        }
    }
    Ok(views)
}

fn fine_inputs(step: &Step, needs: &Needs<'_>) -> Result<Wires> {
    let mut fine = Wires::default();
    for (role, given) in needs {
        if let (Role::Fine(i), Some(wires)) = (role, given.wires()) {
            put(&mut fine, &step.inputs[*i], wires)?;
        }
    }
    Ok(fine)
}

/// The outputs of a global node that are read, on the grid of its consumer.
fn lifted(cx: &Context<'_>, step: &Step, read: Outputs, needs: &Needs<'_>) -> Result<Wires> {
    let base = needs.iter().find_map(|(role, g)| if *role == Role::Base { g.wires() } else { None });
    let base = base.ok_or_else(|| Error::Output {
        port: Name::default(),
        message: "was not computed on the base grid".into(),
    })?;
    let fine = fine_inputs(step, needs)?;
    let mut out = Wires::default();
    for (port, after) in base.iter().filter(|(port, _)| read.has(&step.kind, port)) {
        let carried = step.kind.carries.iter().find(|(output, _)| output == port).map(|(_, input)| input);
        let before = carried.and_then(|input| {
            needs.iter().find_map(|(role, g)| match role {
                Role::Before(i) if step.inputs[*i].port == *input => g.wires()?.get(&step.inputs[*i].from),
                _ => None,
            })
        });
        let value = match (before, carried.and_then(|input| fine.get(input))) {
            (Some(before), Some(fine)) => lift::carry(cx, [fine, before, after], keep(step, port, base)?)?,
            _ => lift::lift(cx, after)?,
        };
        out.put(port.clone(), value);
    }
    Ok(out)
}

/// What weighs the finer detail of a carried output.
fn keep<'a>(step: &Step, port: &str, base: &'a Wires) -> Result<lift::Keep<'a>> {
    match step.node.keep(port) {
        Detail::Whole => Ok(lift::Keep::Number(1.0)),
        Detail::Times(gain) => Ok(lift::Keep::Number(gain as f32)),
        Detail::By(field) => match base.get(field) {
            Some(Value::Field(field)) => Ok(lift::Keep::Field(field)),
            _ => Err(Error::Output {
                port: Name::new(field),
                message: format!("is no field and cannot say what `{port}` keeps"),
            }),
        },
    }
}

/// Law 8: every output that was to be made is there, on its grid, of its type, and finite.
fn check(grid: &Grid, step: &Step, made: Outputs, out: &Wires) -> Result<()> {
    for port in made.ports(&step.kind) {
        let bad = |message: String| Err(Error::Output { port: port.name.clone(), message });
        match out.get(&port.name) {
            None if port.required => return bad("is missing".into()),
            None => (),
            Some(value) if value.wire_type() != port.wire => {
                return bad(format!("is {}, not {}", value.wire_type().name(), port.wire.name()));
            }
            Some(value) if value.grid().is_some_and(|g| g != grid) => {
                return bad(format!("stands on {:?}, not on {grid:?}", value.grid()));
            }
            Some(value) if value.quantity() != step.quantity(&port.name) => {
                let named = |q: Option<Quantity>| q.map_or("nothing", Quantity::name);
                let (got, said) = (named(value.quantity()), named(step.quantity(&port.name)));
                return bad(format!("is {got}, and the kind says {said}"));
            }
            Some(Value::Object(object)) => {
                if let Some(fault) = object.fault() {
                    return bad(fault);
                }
            }
            Some(value) => {
                if let Some((col, row)) = value.first_not_finite() {
                    return Err(Error::NotFinite { port: port.name.clone(), col, row });
                }
            }
        }
    }
    Ok(())
}
