//! Binds: parameters by path, such as `hills.mode.turned.angle` or `terrain.width`, and their values.

use serde_json::Value as Json;

use super::path::{self, Spot};
use super::problem::{Hints, Place, Problem, listed};
use super::{Graph, GraphNode, KindRef, NodeId, json, terrain_params};
use crate::params::Param;
use crate::params::packed::View;

/// The owner of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    Terrain,
    Node(NodeId),
}

/// A parameter of an owner, or a value inside a parameter.
#[derive(Clone, Debug)]
pub(super) struct Bind {
    pub(super) owner: Owner,
    pub(super) path: Vec<String>,
}

/// The most steps in the path of a parameter; those of the shipped kinds have up to four.
pub(super) const MAX_STEPS: usize = 16;

pub(super) fn split(path: &str) -> Vec<String> {
    path.split('.').map(str::to_owned).collect()
}

impl Graph {
    pub(super) fn set_bind(&mut self, bind: &Bind, mut value: Json) -> Result<(), Problem> {
        json::tidy(&mut value);
        let bad = |message| Problem::error(self.place_of(bind), message);
        if let Some(name) = self.exposed_as(bind) {
            return Err(bad(format!("is exposed as `{name}`: set that")));
        }
        let spot = self.spot(bind, &Hints::new()).map_err(bad)?;
        spot.shape.check(&value).map_err(bad)?;
        if self.written_at(bind).is_some_and(|written| written.equals(&value, json::same)) {
            return Ok(());
        }
        self.put_at(bind, value);
        if let Owner::Node(id) = bind.owner {
            self.dag[id].extra.shift_remove("set");
        }
        self.settle();
        Ok(())
    }

    pub(super) fn reset_bind(&mut self, bind: &Bind) -> Result<(), Problem> {
        let bad = |message| Problem::error(self.place_of(bind), message);
        if let Some(name) = self.exposed_as(bind) {
            return Err(bad(format!("is exposed as `{name}`: unexpose it first")));
        }
        let [top] = bind.path.as_slice() else {
            let spot = self.spot(bind, &Hints::new()).map_err(bad)?;
            let default = spot.param.default.clone();
            return self.set_bind(bind, default);
        };
        // A parameter that the kind does not know can be removed, too.
        let written = self.written_at(bind).is_some();
        if !written {
            self.spot(bind, &Hints::new()).map_err(bad)?;
            return Ok(());
        }
        match bind.owner {
            Owner::Terrain => _ = self.settings.shift_remove(top),
            Owner::Node(id) => self.dag[id].set.remove(top),
        }
        self.settle();
        Ok(())
    }

    /// The parameter that a text names: `node.parameter`, `terrain.setting`, and deeper paths.
    pub(super) fn find_bind(&self, text: &str, hints: &Hints) -> Result<Bind, Problem> {
        let Some((owner, path)) = text.split_once('.') else { return Err(self.not_assignable(text, hints)) };
        let owner = match (owner, self.find(owner)) {
            ("terrain", _) => Owner::Terrain,
            (_, Some(id)) => Owner::Node(id),
            (name, None) => {
                let hint = hints.nearest(name, self.names_of_nodes().chain(["terrain"]));
                let message = format!("is not in the graph{hint}");
                return Err(Problem::error(Place::Node(name.to_owned()), message));
            }
        };
        let bind = Bind { owner, path: split(path) };
        if bind.path.len() > MAX_STEPS {
            let message = format!("is a path of {} steps, the limit is {MAX_STEPS}", bind.path.len());
            return Err(Problem::error(self.place_of(&bind), message));
        }
        Ok(bind)
    }

    /// The problem of a name that is no path: a misspelt exposed name, or a parameter without its node.
    fn not_assignable(&self, name: &str, hints: &Hints) -> Problem {
        let exposed = || self.exposed().map(|(n, _)| n);
        let mut hint = hints.nearest(name, exposed());
        if hint.is_empty() {
            let has = |id: &NodeId| self.node(*id).kind().is_some_and(|k| k.param(name).is_some());
            let owner = self.nodes().find(has).map(|id| self.node(id).name.as_str());
            let owner = owner.or(terrain_params().iter().any(|p| p.name == name).then_some("terrain"));
            hint = owner.map(|owner| format!("; did you mean `{owner}.{name}`?")).unwrap_or_default();
        }
        let all = listed(exposed());
        Problem::error(
            Place::Exposed(name.to_owned()),
            format!("is no name that this graph exposes (exposed: {all}), and no `node.parameter`{hint}"),
        )
    }

    /// The parameter, shape and value at a bind.
    pub(super) fn spot(&self, bind: &Bind, hints: &Hints) -> Result<Spot<'_>, String> {
        let params: &[Param] = match bind.owner {
            Owner::Terrain => terrain_params(),
            Owner::Node(id) => match self.node(id).kind() {
                Some(kind) => kind.params(),
                None => {
                    return Err(format!(
                        "cannot be set, since the kind `{}` is not known",
                        self.node(id).kind.id()
                    ));
                }
            },
        };
        let (name, rest) = bind.path.split_first().map_or(("", &[][..]), |(n, rest)| (n.as_str(), rest));
        let Some(param) = params.iter().find(|p| p.name == name) else {
            let names = || params.iter().map(|p| p.name.as_str());
            let whose = if bind.owner == Owner::Terrain { "the terrain's" } else { "this kind's" };
            return Err(format!(
                "is not one of {whose}: {}{}",
                listed(names()),
                hints.nearest(name, names())
            ));
        };
        let top = Bind { owner: bind.owner, path: vec![name.to_owned()] };
        let value = self.written_at(&top).unwrap_or(View::Json(&param.default));
        let rest: Vec<&str> = rest.iter().map(String::as_str).collect();
        path::walk(param, value, &rest, hints)
    }

    pub(super) fn place_of(&self, bind: &Bind) -> Place {
        let path = bind.path.join(".");
        match bind.owner {
            Owner::Terrain => Place::Terrain(path),
            Owner::Node(id) => Place::Parameter { node: self.node(id).name.clone(), parameter: path },
        }
    }

    /// The value that is written at a bind; `None` where the default applies.
    pub(super) fn written_at(&self, bind: &Bind) -> Option<View<'_>> {
        let (first, rest) = bind.path.split_first()?;
        let top = match bind.owner {
            Owner::Terrain => self.settings.get(first).map(View::Json),
            Owner::Node(id) => self.node(id).set.view(first),
        };
        let rest: Vec<&str> = rest.iter().map(String::as_str).collect();
        path::get(top?, &rest)
    }

    /// Writes a value at a bind that resolves. Where the value is there already nothing changes, so that the parsed
    /// parameters of the node stay valid.
    pub(super) fn put_at(&mut self, bind: &Bind, value: Json) {
        if self.written_at(bind).is_some_and(|written| written.equals(&value, |a, b| a == b)) {
            return;
        }
        let Some((first, rest)) = bind.path.split_first() else { return };
        let rest: Vec<&str> = rest.iter().map(String::as_str).collect();
        let default = |params: &[Param]| {
            params.iter().find(|p| p.name == *first).map_or(Json::Null, |p| p.default.clone())
        };
        match bind.owner {
            Owner::Terrain => {
                let top = self.settings.entry(first.as_str()).or_insert_with(|| default(terrain_params()));
                path::put(top, &rest, value);
            }
            Owner::Node(id) => {
                let GraphNode { kind: KindRef::Known(kind), set, .. } = &mut self.dag[id] else { return };
                path::put_packed(set.entry(first, || default(kind.params())), &rest, value);
            }
        }
    }

    /// The name under which a parameter, one that contains it or one inside it is exposed.
    fn exposed_as(&self, bind: &Bind) -> Option<&str> {
        let owner = match bind.owner {
            Owner::Terrain => "terrain",
            Owner::Node(id) => self.node(id).name.as_str(),
        };
        let path = format!("{owner}.{}", bind.path.join("."));
        let inside =
            |a: &str, b: &str| a.strip_prefix(b).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        let meets = |other: &String| inside(other, &path) || inside(&path, other);
        self.exposed().find(|(_, e)| e.bind.iter().any(meets)).map(|(name, _)| name)
    }
}
