//! A program has nothing but what it is given, and ends whatever it does.

use edits::{Argument, EditLog, Selector, TrackEdit};

use crate::body::dance;
use crate::{program, read, refused};

/// What comes of a body of `fn elements`, the second line of its file.
fn ran(body: &str) -> Result<(), String> {
    let text = format!(
        "fn elements(script, params) {{\n{body}\n}}\nfn deeper(n) {{ deeper(n + 1) }}\nfn hold(x) {{ x }}"
    );
    let program = read(&text, &[]).map_err(|e| e.to_string())?;
    let mut tracks = dance();
    let selection = Selector::default().select(&tracks).unwrap();
    program.apply(&mut tracks, &selection, &mut EditLog::default()).map_err(|e| e.to_string())
}

/// A loop without end is stopped, and its line is named.
#[test]
fn an_endless_loop_is_named() {
    for body in [
        "loop { }",
        "let x = 1;\nloop { x += 1; }",
        "let i = 0; while i < 1 { i -= 1; }",
        "let r = 0..9000000000000; for i in r { }",
    ] {
        let said = ran(body).unwrap_err();
        let line = 2 + body
            .lines()
            .position(|l| l.contains("loop") || l.contains("while") || l.contains("for"))
            .unwrap();
        assert!(said.contains("takes more steps than are allowed"), "{body}: {said}");
        assert!(said.contains(&format!("mine.rhai:{line}:")), "{body}: {said}");
    }
    // nor can it be caught
    assert!(ran("try { loop { } } catch { }").is_err());
}

/// Everything that reaches outside is refused.
#[test]
fn there_is_no_way_outside() {
    for body in [
        "import \"std\" as s;",
        "let f = open(\"/etc/passwd\");",
        "let f = open_file(\"/etc/passwd\");",
        "let f = File::open(\"x\");",
        "let x = eval(\"40 + 2\");",
        "let f = Fn(\"eval\"); f.call(\"40 + 2\");",
        "print(\"hello\");",
        "let f = Fn(\"print\"); f.call(\"hello\");",
        "debug(1);",
        "let t = timestamp();",
        "sleep(10);",
        "let t = now();",
        "let x = rand();",
        "let x = 2.0 ** 0.5;",
        "let x = env(\"HOME\");",
        "exit();",
        "let b = blob(1000000000);",
    ] {
        let said = ran(body).expect_err(body);
        // the language knows no place within a function pointer
        let place = if body.contains("Fn(") { "mine.rhai:" } else { "mine.rhai:2:" };
        assert!(said.contains(place), "{body}: {said}");
    }
    // the control: the words around them are fine
    ran("let x = pow(2.0, 0.5); let t = [1, 2].map(|i| i + 1);").unwrap();
}

/// Values and calls are bounded.
#[test]
fn sizes_and_depths_are_bounded() {
    for body in [
        "let s = \"x\"; loop { s += s; }",
        "let s = \"x\"; s.pad(1000000, \"y\");",
        "let a = [1]; loop { a += a; }",
        "let a = []; a.pad(1000000, 0);",
        "let m = #{}; for i in 0..2000000 { m[`k${i}`] = i; }",
        "let a = []; for i in 0..1000000 { a.push([1, 2, 3]); }",
        "deeper(0);",
    ] {
        let said = ran(body).expect_err(body);
        assert!(said.contains("mine.rhai:"), "{body}: {said}");
    }
    let nested = format!("let x = {}1{};", "(".repeat(200), ")".repeat(200));
    assert!(ran(&nested).is_err());
    assert!(ran("deeper(0);").unwrap_err().contains("too deep"));
}

/// Parameters: those the program names, of their kind.
#[test]
fn parameters_are_checked() {
    let text = "fn params() { #{ amount_deg: 2.0, times: 3, on: true, parts: [\"a\"], name: \"x\" } }\nfn elements(script, params) { }";
    let set = |name: &str, value: Argument| {
        read(text, &[(name, value)]).map(|p| p.parameters()).map_err(|e| e.to_string())
    };
    assert!(set("amount_deg", Argument::Number(3.0)).unwrap().contains(&("amount_deg".into(), "3.0".into())));
    for (name, value, message) in [
        (
            "amout_deg",
            Argument::Number(1.0),
            "mine.rhai has no parameter `amout_deg`; did you mean `amount_deg`?",
        ),
        ("times", Argument::Number(1.5), "`times` takes a whole number; found 1.5"),
        ("on", Argument::Number(1.0), "`on` takes true or false; found 1"),
        ("amount_deg", Argument::Number(f64::NAN), "`amount_deg` takes a finite number; found NaN"),
        ("parts", Argument::Text("a".into()), "`parts` takes a list"),
        ("name", Argument::Flag(true), "`name` takes a text; found true"),
    ] {
        let said = set(name, value).unwrap_err();
        assert!(said.contains(message), "{said}");
    }
}

/// What is wrong with the text itself is said when it is read.
#[test]
fn texts_are_checked_when_they_are_read() {
    for (text, message, place) in [
        ("fn elements(script, params) {\n  let x = ;\n}", "", "mine.rhai:2:11"),
        ("fn elements(script, params) {\n  script.note(nme);\n}", "nme", "mine.rhai:2:15"),
        (
            "fn elements(script) { }",
            "`elements` takes 1 argument(s); allowed: `fn elements(script, params)`",
            "mine.rhai:1:1",
        ),
        (
            "\nconst AMOUNT = 3;\nfn elements(script, params) { }",
            "this is outside functions",
            "mine.rhai:2:1",
        ),
        (
            "fn params() { 3 }\nfn elements(script, params) { }",
            "`params` gives i64; allowed: a map",
            "mine.rhai:1:1",
        ),
        ("fn params() { loop { } }", "more steps than are allowed", "mine.rhai:1:"),
    ] {
        let said = refused(text);
        assert!(said.contains(message) && said.contains(place), "{text}: {said}");
    }
    let mut tracks = dance();
    let selection = Selector::default().select(&tracks).unwrap();
    let said = program("fn react(body, params) { }").apply(&mut tracks, &selection, &mut EditLog::default());
    assert!(
        said.unwrap_err().to_string().contains("needs `fn elements(script, params)`; its functions: react")
    );
}
