//! Files made by accident or in malice: a clear error or a kept part, never a panic.

use orograph::graph::{Graph, LoadError, Problem, Severity};

use super::kinds::*;

fn refusal(text: impl AsRef<[u8]>) -> String {
    match Graph::from_bytes(text.as_ref(), &registry()) {
        Err(error) => error.to_string(),
        Ok(graph) => panic!("was read: {}", canonical(&graph)),
    }
}

#[test]
fn what_is_no_graph_is_refused_with_its_place() {
    let cases: &[(&[u8], &str)] = &[
        (b"", "the file is empty"),
        (b" \n\t ", "the file is empty"),
        (
            b"{\"orograph\": 1, \"nodes\": {\"a\": {\"kind\"",
            "the file ends in the middle, at line 1 column 38: was it cut off?",
        ),
        (b"{\"orograph\": 1,\n \"title\": \"\xff\"}", "the file is not UTF-8 text: byte 27, in line 2"),
        (b"{\"orograph\": 1} {}", "the file cannot be parsed: trailing characters, line 1 column 17"),
        (b"{\"orograph\": 1, \"a\": 1,}", "the file cannot be parsed: trailing comma, line 1 column 24"),
        (b"[1]", "`the file` must be an object, got [1]"),
        (b"{}", "this is not a graph: it has no key `orograph` with the version of its format"),
        (
            b"{\"orograph\": 0}",
            "`orograph`, the version of the format, must be a whole number from 1 to 1, got 0",
        ),
        (
            b"{\"orograph\": \"1\"}",
            "`orograph`, the version of the format, must be a whole number from 1 to 1, got \"1\"",
        ),
        (
            b"{\"orograph\": 1.5}",
            "`orograph`, the version of the format, must be a whole number from 1 to 1, got 1.5",
        ),
        (
            b"{\"orograph\": 2}",
            "the file was written by a newer version of Orograph: it has format 2, this version reads up to 1",
        ),
        (b"{\"orograph\": 1, \"nodes\": []}", "`nodes` must be an object, got []"),
        (b"{\"orograph\": 1, \"nodes\": {\"a\": 5}}", "`nodes.a` must be an object, got 5"),
        (b"{\"orograph\": 1, \"nodes\": {\"a\": {}}}", "`nodes.a.kind` is missing"),
        (
            b"{\"orograph\": 1, \"nodes\": {\"a\": {\"kind\": 5}}}",
            "`nodes.a.kind` must be the name of a kind, got 5",
        ),
        (b"{\"orograph\": 1, \"terrain\": 8}", "`terrain` must be an object, got 8"),
        (
            b"{\"orograph\": 1, \"x\": 1e999}",
            "the file cannot be parsed: number out of range, line 1 column 26",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(refusal(text), *expected, "{}", String::from_utf8_lossy(text));
    }
}

#[test]
fn a_key_twice_is_an_error_with_its_path() {
    let nodes = "{\"orograph\": 1,\n  \"nodes\": {\n    \"hills\": {\"kind\": \"hills\"},\n    \"hills\": {\"kind\": \"sum\"}\n  }\n}";
    assert_eq!(refusal(nodes), "the file cannot be parsed: `nodes.hills` is written twice, line 4 column 11");
    let set = r#"{"orograph": 1, "x": [0, {"a": 1, "\u0061": 2}]}"#;
    assert_eq!(refusal(set), "the file cannot be parsed: `x.1.a` is written twice, line 1 column 42");
}

#[test]
fn not_a_number_is_named() {
    for word in ["NaN", "Infinity", "-Infinity", "nan", "-inf"] {
        let text = format!(
            "{{\"orograph\": 1,\n\"nodes\": {{\"a\": {{\"kind\": \"hills\", \"set\": {{\"amplitude\": {word}}}}}}}}}"
        );
        let told = refusal(&text);
        let plain = word.trim_start_matches('-');
        assert!(told.contains(&format!("`{plain}` is not a number in JSON, line 2")), "{told}");
    }
    let word = refusal(r#"{"orograph": 1, "title": hills}"#);
    assert_eq!(
        word,
        "the file cannot be parsed: `hills` is not a value; texts stand in quotes, line 1 column 26"
    );
    let graph = with_nodes(r#""a": {"kind": "hills", "set": {"amplitude": "NaN"}}"#);
    has(&errors(&graph), &["node `a`, parameter `amplitude`: must be a number from 0 to 5000, got \"NaN\""]);
}

#[test]
fn endless_things_are_refused() {
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let deep = format!("{{\"orograph\": 1, \"x\": {}1{}}}", open.repeat(10_000), close.repeat(10_000));
        let told = refusal(&deep);
        assert!(told.contains("nested more than 127 levels deep, line 1"), "{told}");
        assert!(refusal(open.repeat(100_000)).contains("nested more than 127 levels deep"));
    }
    let deepest = format!("{{\"orograph\": 1, \"x\": {}{}}}", "[".repeat(126), "]".repeat(126));
    let kept = load(&deepest);
    assert_eq!(canonical(&load(&canonical(&kept))), canonical(&kept));

    let large = vec![b' '; 100_000_000];
    assert_eq!(refusal(&large), "the file has 100000000 bytes, the limit is 16777216");
    let many = format!("{{\"orograph\": 1, \"x\": [{}0]}}", "0,".repeat(1_000_000));
    assert!(refusal(&many).contains("the file holds more than 1000000 values"));
    let text = format!("{{\"orograph\": 1, \"about\": \"{}\"}}", "x".repeat(70_000));
    assert!(refusal(&text).contains("`about` is a text of 70000 bytes, the limit is 65536"));
    let key = format!("{{\"orograph\": 1, \"{}\": 1}}", "k".repeat(300));
    assert!(refusal(&key).contains("the file has a key of 300 bytes, the limit is 256"));
    let nodes: Vec<_> = (0..20_001).map(|i| format!("\"n{i}\": {{\"kind\": \"hills\"}}")).collect();
    let text = format!("{{\"orograph\": 1, \"nodes\": {{{}}}}}", nodes.join(","));
    assert_eq!(refusal(&text), "the file has 20001 nodes, the limit is 20000");
}

#[test]
fn every_beginning_of_a_file_is_refused_without_a_panic() {
    for end in 0..EXAMPLE.len() - 2 {
        let error = Graph::from_bytes(&EXAMPLE.as_bytes()[..end], &registry()).unwrap_err();
        assert!(matches!(error, LoadError::Truncated { .. } | LoadError::Empty), "{end}: {error}");
    }
}

#[test]
fn cycles_are_named_and_stop_only_what_reads_them() {
    let graph = with_nodes(
        r#""start": {"kind": "hills"}, "a": {"kind": "sum", "in": {"a": "c.field", "b": "start.field"}},
        "b": {"kind": "sum", "in": {"a": "a.field"}}, "c": {"kind": "sum", "in": {"a": "b.field"}},
        "self": {"kind": "sum", "in": {"a": "self.field"}}, "below": {"kind": "sum", "in": {"a": "c.field"}},
        "free": {"kind": "sum", "in": {"a": "start.field"}}"#,
    );
    let told = errors(&graph);
    assert_eq!(
        told,
        ["node `a`: is on a cycle: `a` > `b` > `c` > `a`", "node `self`: is on a cycle: `self` > `self`",]
    );
    assert_eq!(graph.order().unwrap_err().to_string(), told[0]);
    let free = graph.order_of(&[id(&graph, "free")]).unwrap();
    assert_eq!(free, [id(&graph, "start"), id(&graph, "free")]);
    graph.order_of(&[id(&graph, "below")]).unwrap_err();
    let cycle = graph.problems().into_iter().find(Problem::is_error).unwrap();
    assert!(cycle.stops("x", &graph.upstream(id(&graph, "below"))));
    assert!(!cycle.stops("x", &graph.upstream(id(&graph, "free"))));
    assert_eq!(canonical(&load(&canonical(&graph))), canonical(&graph));
}

#[test]
fn a_long_chain_and_a_long_cycle_need_no_stack() {
    let n = 20_000;
    let node = |i: usize, from: usize| {
        format!("\"n{i}\": {{\"kind\": \"sum\", \"in\": {{\"a\": \"n{from}.field\"}}}}")
    };
    let ring: Vec<_> = (0..n).map(|i| node(i, (i + 1) % n)).collect();
    let graph = with_nodes(&ring.join(","));
    let told = errors(&graph);
    assert_eq!(told.len(), 1);
    assert!(
        told[0].contains("node `n0`: is on a cycle: `n0` > `n19999`") && told[0].contains("more) …"),
        "{}",
        told[0]
    );
    let chain: Vec<_> = (0..n).map(|i| node(i, i + 1)).collect();
    let graph = with_nodes(&format!(
        "{}, \"n{n}\": {{\"kind\": \"hills\"}}",
        chain[..n - 1].join(",").replace("n19999.", "n20000.")
    ));
    assert_eq!(graph.order().unwrap().len(), n);
    assert_eq!(graph.upstream(id(&graph, "n0")).len(), n);
    assert_eq!(graph.downstream(id(&graph, "n20000")).len(), n);
}

#[test]
fn many_small_cycles_are_found_in_time() {
    let pairs: Vec<_> = (0..10_000)
        .map(|i| format!("\"a{i}\": {{\"kind\": \"sum\", \"in\": {{\"a\": \"b{i}.field\"}}}}, \"b{i}\": {{\"kind\": \"sum\", \"in\": {{\"a\": \"a{i}.field\"}}}}"))
        .collect();
    let graph = with_nodes(&pairs.join(","));
    let problems = graph.problems();
    assert!(problems.iter().filter(|p| p.is_error()).count() > 10_000);
    for name in ["a0", "a5000", "b9999"] {
        let upstream = graph.upstream(id(&graph, name));
        assert!(problems.iter().any(|p| p.stops("x", &upstream)), "{name} would run");
    }
}

#[test]
fn every_fault_inside_a_graph_names_its_place() {
    let text = r#"{"orograph": 1, "kinds": {"hills": 1}, "terrain": {"width": 0, "base": 1000000, "seed": -1, "origin": [0], "wdth": 3, "geo": {"epsg": 3}},
    "expose": {"Bad": {"bind": ["a.octaves"]}, "none": {"bind": []}, "far": {"bind": ["zz.octaves"], "value": 3},
        "typo": {"bind": ["a.amplitud"], "value": 3}, "twice": {"bind": ["a.octaves"], "value": 3}, "high": {"bind": ["a.amplitude"], "value": 9999},
        "mixed": {"bind": ["b.minus", "a.seed"], "value": true}, "narrow": {"bind": ["a.seed"], "value": 5, "min": 10, "max": 20}, "extra": {"bind": ["b.minus"], "colour": 3}},
    "nodes": {
        "a": {"kind": "hills", "set": {"octaves": 1000000000, "amplitude": -3, "mode": "turnd", "octavs": 3}},
        "b": {"kind": "sum", "in": {"a": "flow.direction", "mask": "hils.field"}},
        "c": {"kind": "sums", "inn": {}}, "d": {"kind": "sum", "set": 5, "in": []},
        "flow": {"kind": "flow", "in": {"field": "a.feld", "fild": "a.field"}},
        "e": {"kind": "graph:inner"}, "f": {"kind": "file:x.graph"},
        "Upper": {"kind": "hills"}, "terrain": {"kind": "hills", "set": {"seed": 1}}, "g/h": {"kind": "hills", "set": {"seed": 2}},
        "last": {"kind": "hills", "set": {"amplitude": 4500, "octaves": 14}}, "bad_input": {"kind": "sum", "in": {"a": 3, "b": "x"}}},
    "outputs": {"con": {"from": "a.field"}, "COM1": {"from": "a.field"}, "lpt9": {"from": "a.field"}, "../x": {"from": "a.field"}, "one": {"from": "a.feld"}, "two": {},
        "three": {"from": 5}, "four": {"from": "hils.field"}, "five": {"from": "a.field", "range": [5, 5], "target": "unrael", "clip": 1},
        "six": {"from": "a.field", "range": [1]}, "SIX": {"from": "a.field"}},
    "inputs": {}, "graphs": {}, "titel": "x", "title": 5}"#;
    let graph = load(text);
    let told = told(&graph);
    let expected: &[&[&str]] = &[
        &["terrain, setting `width`: must be a number from 1 to 20000000, got 0"],
        &["terrain, setting `base`: must be a whole number from 3 to 16385, got 1000000"],
        &["terrain, setting `seed`: must be a whole number from 0 to 4294967295, got -1"],
        &["terrain, setting `origin`: must have 2 items, got 1"],
        &["terrain, setting `wdth`: is not known", "did you mean `width`?"],
        &["terrain, setting `geo`: ", "needs epsg, east and north"],
        &["exposed `Bad`: must have a name of 1 to 64 of the characters a to z, 0 to 9 and _"],
        &["exposed `none`: `bind` must have from 1 to 1000 items, got 0"],
        &["exposed `far`: cannot bind `zz.octaves`: node `zz`: is not in the graph"],
        &[
            "exposed `typo`: cannot bind `a.amplitud`: node `a`, parameter `amplitud`: ",
            "did you mean `amplitude`?",
        ],
        &["exposed `twice`: cannot bind `a.octaves`: it is exposed as `Bad` already"],
        &["exposed `high`: must be a number from 0 to 5000, got 9999"],
        &["exposed `mixed`: binds `a.seed`, whose values are of another kind"],
        &["exposed `narrow`: cannot bind `a.seed`", "exposed as `mixed`"],
        &["exposed `extra`: the key `colour` is not known"],
        &["node `a`, parameter `octaves`: must be a whole number from 1 to 16, got 1000000000"],
        &["node `a`, parameter `amplitude`: must be a number from 0 to 5000, got -3"],
        &["node `a`, parameter `mode`: must be one of plain, turned, got \"turnd\"; did you mean `turned`?"],
        &["node `a`, parameter `octavs`: is not one of this kind's: ", "did you mean `octaves`?"],
        &["node `b`, input `a`: takes ", "but `flow.direction` gives "],
        &["node `b`, input `mask`: reads `hils.field`, but the graph has no node `hils`"],
        &["node `c`: is of kind `sums`, which is not known, and kept as it is; did you mean `sum`?"],
        &["node `c`: the key `inn` is not known", "did you mean `in`?"],
        &["node `d`: `set` must be an object"],
        &["node `d`: `in` must be an object"],
        &["node `d`, input `a`: must be connected"],
        &[
            "node `flow`, input `field`: reads `a.feld`, but `a` has no output `feld`; it has `field`; did you mean `field`?",
        ],
        &["node `flow`, input `fild`: `flow` has no such input; it has `field`; did you mean `field`?"],
        &["node `e`: ", "graphs as nodes are not yet supported"],
        &["node `f`: ", "graphs as nodes are not yet supported"],
        &["node `Upper`: must have a name of 1 to 64"],
        &["node `terrain`: cannot have the name of the terrain's settings"],
        &["node `g/h`: must have a name of 1 to 64"],
        &["node `last`, parameter `octaves`: must be at most 12 above 4000 m, got 14"],
        &["node `bad_input`, input `a`: must be written as `node.port`, got 3"],
        &["node `bad_input`, input `b`: must be written as `node.port`, got `x`"],
        &["output `con`: has a name that Windows keeps for a device"],
        &["output `lpt9`: has a name that Windows keeps for a device"],
        &["output `COM1`: must have a name of 1 to 64"],
        &["output `../x`: must have a name of 1 to 64"],
        &["output `one`: reads `a.feld`, but `a` has no output `feld`"],
        &["output `two`: needs `from`"],
        &["output `three`: `from` must be a text, got 5"],
        &["output `four`: reads `hils.field`, but the graph has no node `hils`"],
        &["output `five`: `range` must be a lower and a higher number, got [5, 5]"],
        &[
            "output `five`: `target` must be one of unreal, unity, godot, got \"unrael\"; did you mean `unreal`?",
        ],
        &["output `five`: `clip` must be true or false, got 1"],
        &["output `six`: `range` must have 2 items, got 1"],
        &["output `SIX`: has the name of the output `six` but for upper and lower case"],
        &["graph: `inputs` is not yet supported by this version, and kept as it is"],
        &["graph: `graphs` is not yet supported"],
        &["graph: the key `titel` is not known", "did you mean `title`?"],
        &["graph: `title` must be a text, got 5"],
    ];
    for words in expected {
        has(&told, words);
    }
    // Nothing is lost: the canonical form has all of it, and says the same of itself.
    let again = load(&canonical(&graph));
    assert_eq!(super::kinds::told(&again), told);
    assert_eq!(graph.to_bytes(), text.as_bytes());
    assert_eq!(graph.terrain(), &orograph::value::Terrain::default());
}

#[test]
fn settings_that_do_not_fit_together_leave_a_terrain_that_works() {
    let graph = load(r#"{"orograph": 1, "terrain": {"width": 1000, "depth": 777, "base": 512}}"#);
    has(&errors(&graph), &["terrain, setting `base`: ", "does not divide the other side"]);
    assert_eq!(graph.terrain().fault(), None);
    assert_eq!(graph.terrain_settings()["depth"], 777);
    assert!(graph.problems().iter().any(|p| p.stops("any", &std::collections::BTreeSet::new())));
    let graph = load(
        r#"{"orograph": 1, "terrain": {"width": 0}, "nodes": {"a": {"kind": "hills"}}, "outputs": {"o": {"from": "a.field"}}}"#,
    );
    let told = graph.output_source("o").unwrap_err().to_string();
    assert_eq!(told, "terrain, setting `width`: must be a number from 1 to 20000000, got 0");
}

#[test]
fn errors_stop_only_what_lies_downstream() {
    let graph = load(
        r#"{"orograph": 1, "nodes": {"good": {"kind": "hills"}, "bad": {"kind": "hills", "set": {"octaves": 99}},
        "reads_bad": {"kind": "sum", "in": {"a": "bad.field"}}}, "outputs": {"a": {"from": "good.field"}, "b": {"from": "reads_bad.field"}, "c": {"from": "nobody.x"}}}"#,
    );
    let problems = graph.problems();
    let stopped = |name: &str| {
        let upstream = graph.output_source(name).map(|s| graph.upstream(s.node)).unwrap_or_default();
        problems.iter().any(|p| p.stops(name, &upstream))
    };
    assert!(!stopped("a"));
    assert!(stopped("b"));
    assert!(stopped("c"));
    let bad = problems.iter().find(|p| p.severity == Severity::Error).unwrap();
    assert_eq!(bad.blames(), graph.find("bad"));
    let missing = graph.output_source("hight").unwrap_err().to_string();
    assert_eq!(missing, "output `hight`: is not an output of this graph; it has `a`, `b`, `c`");
}

#[test]
fn a_hundred_thousand_slips_of_the_pen_are_told_in_time() {
    let node = |i: usize| {
        format!(
            "\"n{i}\": {{\"kind\": \"summ\", \"att\": 1, \"in\": {{\"a\": \"nn{i}.field\"}}}}, \"h{i}\": {{\"kind\": \"hills\", \"set\": {{\"octavs\": 1, \"sed\": 2}}}}, \"s{i}\": {{\"kind\": \"sum\", \"in\": {{\"a\": \"m{i}.field\", \"c\": \"x\"}}}}"
        )
    };
    let nodes: Vec<_> = (0..6000).map(node).collect();
    let binds: Vec<_> = (0..1000)
        .map(|i| format!("\"e{i}\": {{\"bind\": [{}]}}", vec![format!("\"h{i}.sed\""); 100].join(",")))
        .collect();
    let text = format!(
        "{{\"orograph\": 1, \"expose\": {{{}}}, \"nodes\": {{{}}}}}",
        binds.join(","),
        nodes.join(",")
    );
    let start = std::time::Instant::now();
    let graph = load(&text);
    let found = graph.problems().len();
    assert!(found > 100_000, "{found}");
    // Far above what it takes even on a loaded machine, far below what comparing every name with every other would.
    assert!(start.elapsed().as_secs() < 30, "{:?}", start.elapsed());
}

#[test]
fn twins_and_graphs_without_outputs_earn_a_warning() {
    let graph = with_nodes(
        r#""one": {"kind": "hills", "set": {"seed": 5}}, "two": {"kind": "hills", "set": {"octaves": 8, "seed": 5}},
        "other": {"kind": "hills", "set": {"seed": 6}}, "flat": {"kind": "constant"}, "flat_too": {"kind": "constant"}"#,
    );
    assert_eq!(
        told(&graph),
        [
            "node `two`, parameter `seed`: is that of `one`, and all other parameters are the same: twins",
            "graph: has no outputs, so that nothing would be built",
        ]
    );
    assert!(graph.problems().iter().all(|p| p.severity == Severity::Warning));
}

#[test]
fn an_input_that_a_node_does_not_use_is_not_missed() {
    let graph = with_nodes(
        r#""hills": {"kind": "hills"}, "s": {"kind": "sum", "in": {"b": "hills.field"}, "set": {"only_second": true}},
        "t": {"kind": "sum", "in": {"a": "nobody.field", "b": "hills.field"}, "set": {"only_second": true}}"#,
    );
    assert_eq!(errors(&graph), [""; 0]);
    has(&told(&graph), &["node `t`, input `a`: reads `nobody.field`, but the graph has no node `nobody`"]);
}

#[test]
fn an_output_with_a_fault_has_no_source() {
    let graph = load(
        r#"{"orograph": 1, "nodes": {"a": {"kind": "hills"}, "b": {"kind": "hills"}}, "expose": {
        "high": {"bind": ["a.octaves", "a.amplitude"], "value": 99}, "typo": {"bind": ["a.octavs"], "value": 1}, "Bad": {"bind": ["b.seed"]}},
        "outputs": {"../x": {"from": "b.field"}, "aux": {"from": "b.field"}, "a": {"from": "a.field"}, "b": {"from": "b.field"},
        "range": {"from": "b.field", "range": [2, 1]}, "format": {"from": "b.field", "format": "doc"}, "B": {"from": "b.field"}}}"#,
    );
    for (output, words) in [
        ("../x", "must have a name of"),
        ("aux", "Windows keeps for a device"),
        ("a", "exposed `high`: must be a whole number from 1 to 16, got 99"),
        ("range", "must be a lower and a higher number"),
        ("format", "must be one of png8"),
        ("B", "must have a name of"),
    ] {
        match graph.output_source(output) {
            Err(problem) => assert!(problem.to_string().contains(words), "{output}: {problem}"),
            Ok(_) => panic!("{output} has a source"),
        }
    }
    assert!(graph.output_source("b").is_ok(), "a name that does not fit stops nothing");
    let broken = load(
        r#"{"orograph": 1, "nodes": {"a": {"kind": "hills"}}, "expose": {"sea": {"bind": ["terrain.sea_level", "a.ghost"], "value": 3}},
        "outputs": {"a": {"from": "a.field"}}}"#,
    );
    let told = broken.output_source("a").unwrap_err().to_string();
    assert!(
        told.starts_with(
            "terrain, setting `sea_level`: is exposed as `sea`, which has a fault: it cannot bind `a.ghost`"
        ),
        "{told}"
    );
}

/// Found by fuzzing: what the file leaves out was written as empty, and then had another fault.
#[test]
fn what_is_left_out_stays_left_out() {
    let graph = load(
        r#"{"orograph": 1, "nodes": {"a": {"kind": "hills"}}, "expose": {"none": {"about": "x"}, "far": {"bind": ["b.octaves"]}, "null": {"bind": ["a.scale"], "value": null}},
        "outputs": {"o": {"clip": true}}}"#,
    );
    let text = canonical(&graph);
    assert!(
        text.contains(r#""none": { "about": "x" },"#)
            && text.contains(r#""far": { "bind": ["b.octaves"] },"#),
        "{text}"
    );
    assert!(text.contains(r#""o": { "clip": true }"#), "{text}");
    let again = load(&text);
    assert_eq!(told(&again), told(&graph));
    assert_eq!(again.canonical(), graph.canonical());
    assert_eq!(
        again.node(id(&again, "a")).parse().map(|n| n.canonical()),
        graph.node(id(&graph, "a")).parse().map(|n| n.canonical())
    );
}
