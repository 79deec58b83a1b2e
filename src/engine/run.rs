//! The runner, which schedules the tasks of a plan: independent tasks run side by side, within the memory budget.
//!
//! Tasks start in the order of the plan. The first task that is not done may always start, because the estimated peak
//! is that of running in order. Later tasks start ahead of it only while their bytes fit beside those of the tasks
//! before them. The account therefore never exceeds the estimate, and the runner never deadlocks.

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
use super::observer::{Observer, TaskReport};
use super::options::Keep;
use super::plan::{Plan, Role, Task};
use super::stage::{perform, views};
use crate::context::Onlooker;
use crate::node::{Cancel, Context, Error, Kind, Result};
use crate::ports::Wires;
use crate::value::Value;
use crate::work::Work;

/// The end of a task: its result, or the failure.
type End = Result<Arc<Given>, SharedFailure>;

/// The results of a plan.
pub(super) struct Ran {
    pub wanted: Vec<Result<Arc<Given>, SharedFailure>>,
    pub reports: Vec<TaskReport>,
    /// Whether a file of the cache folder that the plan relied on could not be used.
    pub is_cache_lost: bool,
    /// The most bytes that were alive at once, by account.
    pub peak_bytes: u64,
}

/// A plan and what it needs to run.
pub(super) struct Runner<'a> {
    pub plan: &'a Plan,
    /// Results of the plan that were in memory, by task.
    pub held: Vec<Option<(Given, Warnings)>>,
    pub store: &'a Store,
    pub keep: Keep,
    pub pool: &'a rayon::ThreadPool,
    pub observer: &'a dyn Observer,
    pub cancel: &'a Cancel,
    /// The most bytes that may be alive at once, by account; at least the peak of the plan.
    pub limit: u64,
}

/// Number of tasks beyond the first unfinished one among which the runner looks for the next to start. It is enough for
/// any number of threads, and keeps the search short where thousands of tasks are ready.
const LOOK_AHEAD: usize = 1024;

/// The progress of a run.
struct State {
    ends: Vec<Option<End>>,
    /// For each task, the number of tasks it needs that are not done.
    missing: Vec<usize>,
    /// Tasks that have not started and whose needs are done.
    ready: BTreeSet<usize>,
    /// Number of tasks that run; it does not exceed the number of threads, since further tasks would only hold memory.
    running: usize,
    /// The first task that is not done.
    first: usize,
    /// For each task, how often its result will still be read.
    uses: Vec<usize>,
    reports: BTreeMap<usize, TaskReport>,
    /// Bytes that each task beyond the first unfinished one holds.
    ahead: BTreeMap<usize, u64>,
    held: Vec<Option<(Given, Warnings)>>,
    /// Bytes that are alive, by account.
    alive: u64,
    peak: u64,
    is_cache_lost: bool,
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
            is_cache_lost: false,
        }
    }

    /// Marks a task as started and returns the results that it needs.
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
            is_cache_lost: state.is_cache_lost,
            peak_bytes: state.peak,
        }
    }

    /// Starts every task that is ready and may start. Each task, when it ends, starts further ones.
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
                guard.is_cache_lost |= lost;
                self.finish(&mut guard, i, task, end, report);
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
        if self.cancel.is_cancelled() || state.is_cache_lost || state.running >= threads {
            return None;
        }
        let first = state.ready.first().copied()?;
        if first == state.first {
            return Some(first);
        }
        let (course, tasks) = (&self.plan.peak.course, &self.plan.tasks);
        let ahead: u64 = state.ahead.values().sum();
        // The most bytes that the tasks up to `reached` hold while they run in order.
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

    /// Records the end of a task and releases the results that no task will read any more.
    fn finish(&self, state: &mut State, i: usize, task: &Task, end: End, report: TaskReport) {
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
                // The task stays marked as done without its values.
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

    /// Runs a task, or takes its result from the cache. The last of the three results says whether a file of the cache
    /// folder was lost.
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
                    Ok(given) => Ok(self.stored(task, &step.kind, given, &warnings)),
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

    /// Reads a result from the cache folder.
    fn load(&self, path: &Path, task: &Task, kind: &Kind) -> io::Result<Given> {
        let (Some(disk), Some(key)) = (&self.store.disk, task.key) else {
            return Err(io::ErrorKind::NotFound.into());
        };
        disk.get(path, &key, &task.grid, kind)
    }

    /// Computes the result of a task and stores it in the caches.
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
        // Progress arrives from many threads; the observer is told of steps of a hundredth.
        let last = AtomicU64::new(0);
        let progress = |share: f32| {
            let now = (f64::from(share) * 100.0) as u64;
            if last.fetch_max(now, Ordering::Relaxed) < now {
                self.observer.progress(i, share);
            }
        };
        // Warnings arrive from any thread, in any order, and perhaps more than once; the set sorts them.
        let said = Mutex::new(BTreeSet::new());
        let warn = |message: String| {
            said.lock().unwrap_or_else(PoisonError::into_inner).insert(message);
        };
        let looks = |port: &str| self.observer.looks(i, port);
        let take = |port: &str, value: Value| self.observer.state(i, port, value);
        let cx = Context {
            grid: task.grid,
            reads: step.kind.reads,
            world: &self.plan.program.terrain,
            whole: summary,
            views: &views,
            files: &step.files,
            work: Work::new(self.cancel).telling(&progress).warning(&warn),
            onlooker: Some(Onlooker { looks: &looks, take: &take }),
        };
        let work = || perform(&cx, task, step, &needs);
        let given = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(panicked(&*panic)));
        *warnings = said.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect();
        let given = given?;
        // A file of the cache holds no warnings, and a quick kind computes its result sooner than a file is read.
        let is_for_disk = given.is_kept() && warnings.is_empty() && !step.kind.quick;
        let disk = self.store.disk.as_ref().filter(|_| is_for_disk);
        if let Some((disk, key)) = disk.zip(task.key) {
            disk.put(&key, &task.grid, &given);
        }
        Ok(self.stored(task, &step.kind, given, warnings))
    }

    /// Stores a result in memory as far as `keep` says, and returns the part that is read.
    fn stored(&self, task: &Task, kind: &Kind, given: Given, warnings: &Warnings) -> Arc<Given> {
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

/// The error of a node that panicked.
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
