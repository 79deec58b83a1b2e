//! How often work looks whether it should stop, by the clock of the processor: for law 12.
//!
//! An engine of one thread runs its tasks one after the other on one worker; what passes there from look to look, the
//! start and the end of a task among them, is what a person waits who asks it to stop.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use cpu_time::ThreadTime;
use orograph::engine::{EngineError, Observer, Plan, Stage, Want};
use orograph::graph::Graph;
use orograph::node::{Cancel, Kind};
use orograph::value::Grid;

use super::graph;

/// A task of the watched node, by node and stage.
type Task = (String, Stage);

/// What was seen of a task.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seen {
    pub looks: usize,
    /// The longest time of the processor from look to look.
    pub longest: Duration,
    pub total: Duration,
    /// How often a share was told that is neither nothing nor all.
    pub told: usize,
    /// From the look that stopped it to its end.
    pub stopping: Option<Duration>,
}

thread_local! {
    /// The task of this thread, and when it last looked.
    static SPAN: Cell<Option<(usize, ThreadTime)>> = const { Cell::new(None) };
}

#[derive(Clone, Default)]
struct Watch {
    plan: Arc<Mutex<Vec<Task>>>,
    seen: Arc<Mutex<BTreeMap<Task, Seen>>>,
    /// The task that is stopped, at which of its looks.
    stop: Option<Arc<(Task, usize)>>,
}

impl Watch {
    fn task<T>(&self, task: usize, enter: impl FnOnce(&Task, &mut Seen) -> T) -> T {
        let name = self.plan.lock().unwrap()[task].clone();
        enter(&name, self.seen.lock().unwrap().entry(name.clone()).or_default())
    }

    /// Enters what passed since the last look; whether to stop here.
    fn look(&self, end: bool) -> bool {
        let Some((task, since)) = SPAN.get() else { return false };
        let passed = since.elapsed();
        let stop = self.task(task, |name, seen| {
            seen.looks += usize::from(!end);
            seen.longest = seen.longest.max(passed);
            seen.total += passed;
            seen.stopping = seen.stopping.map(|before| before + passed);
            let stop = !end && self.stop.as_ref().is_some_and(|s| s.0 == *name && s.1 == seen.looks);
            if stop {
                seen.stopping = Some(Duration::ZERO);
            }
            stop
        });
        SPAN.set((!end).then(|| (task, ThreadTime::now())));
        stop
    }
}

impl Observer for Watch {
    fn planned(&self, plan: &Plan) {
        *self.plan.lock().unwrap() = plan.tasks().into_iter().map(|t| (t.node, t.stage)).collect();
    }

    fn started(&self, task: usize) {
        SPAN.set(Some((task, ThreadTime::now())));
    }

    fn progress(&self, task: usize, share: f32) {
        self.task(task, |_, seen| seen.told += usize::from(share > 0.0 && share < 1.0));
    }

    fn finished(&self, _: usize, _: f64) {
        self.look(true);
    }
}

/// Evaluates all outputs of the node of a graph of the rig on one thread; what was seen of its own tasks.
pub(crate) fn watched(graph: &Graph, kind: &Kind, grid: Grid) -> Result<Vec<(Stage, Seen)>, String> {
    let watch = Watch::default();
    evaluate(graph, kind, grid, &watch).map_err(|e| e.to_string())??;
    let seen = watch.seen.lock().unwrap();
    let own = seen.iter().filter(|((node, _), _)| node == "node");
    Ok(own.map(|((_, stage), seen)| (*stage, seen.clone())).collect())
}

/// The same, stopped at one of the looks of the node's task of a stage; what passed until that task ended.
pub(crate) fn stopped(
    graph: &Graph,
    kind: &Kind,
    grid: Grid,
    stage: Stage,
    look: usize,
) -> Result<Duration, String> {
    let stop = Some(Arc::new((("node".to_owned(), stage), look)));
    let watch = Watch { stop, ..Watch::default() };
    let ended = evaluate(graph, kind, grid, &watch);
    let seen = watch.seen.lock().unwrap();
    let stopping = seen.values().find_map(|s| s.stopping).ok_or("it was not there to be stopped")?;
    match ended {
        Err(EngineError::Cancelled) => Ok(stopping),
        other => Err(format!("it went on after it was stopped: {other:?}")),
    }
}

fn evaluate(
    graph: &Graph,
    kind: &Kind,
    grid: Grid,
    watch: &Watch,
) -> Result<Result<(), String>, EngineError> {
    let asked = watch.clone();
    let cancel = Cancel::asking(move || asked.look(false));
    let node = graph.find("node").unwrap();
    let wants: Vec<_> = kind.outputs.iter().map(|p| Want { node, port: p.name.clone(), grid }).collect();
    let all = graph::engine(1).evaluate(graph, &wants, watch, &cancel)?;
    Ok(all.values.into_iter().try_for_each(|v| v.map(drop).map_err(|f| f.to_string())))
}
