//! What no force depends on is not looked into: it may hold anything. What makes forces is read to the word.

use std::path::Path;

use formats::model::{ImportOptions, Imported, open};
use formats::model_file::Effect;

const ALL: ImportOptions = ImportOptions { dynamics_only: false };

fn read(name: &str, text: &str) -> Result<Imported, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    open(&path, &ALL).map_err(|e| e.to_string())
}

fn case(name: &str) -> Imported {
    let path = support::shared(&format!("cases/models/{name}"));
    open(&path, &ALL).unwrap_or_else(|e| panic!("{e}"))
}

/// What was left out, without places.
fn left_out(imported: &Imported) -> Vec<String> {
    imported.left_out.iter().map(|item| format!("{} ({})", item.what, item.reason)).collect()
}

#[test]
fn robots_with_notes_for_other_programs_are_read_and_the_notes_listed() {
    let ratings = "joint `j`: limit: effort, velocity (ratings of the motor)";
    assert_eq!(left_out(&case("gazebo_text.urdf")), [ratings, "gazebo (for another program)"]);
    assert_eq!(
        left_out(&case("transmission_text.urdf")),
        [ratings, "transmission `t` (how a motor is attached)"]
    );
    assert_eq!(left_out(&case("zero_sphere.urdf")), ["link `b`: visual (look)"]);
    assert_eq!(left_out(&case("mujoco_tag.urdf")), ["mujoco (for another program)", ratings]);
    for name in ["gazebo_text", "transmission_text", "zero_sphere", "mujoco_tag"] {
        let robot = case(&format!("{name}.urdf"));
        assert_eq!((robot.joints.len(), robot.character.mass()), (1, 1.0), "{name}");
    }
}

const ANYTHING: &str = "text <unknown radius=\"0\" size=\"a b\">more <x/> text</unknown> > <geom size=\"-1\"/><origin rpy=\"?\"/>";

/// A model with a note inside is the model without it, and the note is in the list.
fn same(name: &str, around: (&str, &str), note: (&str, &str)) {
    let with = |inside: &str| {
        let text = format!("{}<{} {}>{inside}</{}>{}", around.0, note.0, note.1, note.0, around.1);
        read(name, &text).unwrap_or_else(|e| panic!("{}: {e}", note.0))
    };
    let (plain, full) = (with(""), with(ANYTHING));
    assert_eq!(plain.character, full.character, "{}", note.0);
    assert_eq!(left_out(&plain), left_out(&full), "{}", note.0);
    assert!(left_out(&full).iter().any(|item| item.contains(note.0)), "{}: {:?}", note.0, left_out(&full));
    assert!(full.left_out.iter().all(|item| item.effect == Effect::Look), "{}", note.0);
}

const INERTIAL: &str = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
const HINGE: &str = "<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint>";

#[test]
fn looks_of_a_urdf_may_hold_anything() {
    let head = "<robot name=\"r\"><link name=\"a\"/>";
    let robot = format!("<link name=\"b\">{INERTIAL}</link>{HINGE}</robot>");
    for note in ["gazebo", "transmission", "sensor", "material", "mujoco", "ros2_control", "plugin"] {
        same("r.urdf", (head, &robot), (note, "name=\"n\""));
    }
    let link = (format!("{head}<link name=\"b\">{INERTIAL}"), format!("</link>{HINGE}</robot>"));
    for note in ["visual", "sensor", "gazebo"] {
        same("r.urdf", (&link.0, &link.1), (note, ""));
    }
}

#[test]
fn looks_of_an_mjcf_may_hold_anything() {
    let body = "<worldbody><body><joint/><geom size=\"1\"/></body></worldbody></mujoco>";
    for note in ["visual", "statistic", "size", "custom", "sensor"] {
        same("m.xml", ("<mujoco>", body), (note, ""));
    }
    for note in ["texture", "material", "skin"] {
        same("m.xml", ("<mujoco><asset>", &format!("</asset>{body}")), (note, ""));
    }
    let inside = ("<mujoco><worldbody><body><joint/><geom size=\"1\"/>", "</body></worldbody></mujoco>");
    for note in ["camera", "light"] {
        same("m.xml", inside, (note, ""));
    }
}

/// A `>` too many says nothing; it is listed wherever it stands.
#[test]
fn a_bracket_too_many_is_listed() {
    let text = format!(
        "<robot name=\"r\"><link name=\"a\"/>><link name=\"b\">{}</link>{HINGE}</robot>",
        INERTIAL.replace("<mass value=\"1\"/>", "<mass value=\"1\"/>>")
    );
    let robot = read("r.urdf", &text).unwrap();
    assert_eq!(
        left_out(&robot),
        ["`>` inside <robot> (a bracket too many)", "`>` inside <inertial> (a bracket too many)"]
    );
    assert_eq!(robot.left_out[0].place.column, 33);
}

#[test]
fn physics_is_read_to_the_word() {
    let robot = |inside: &str| {
        let text = format!("<robot name=\"r\"><link name=\"a\">{inside}</link></robot>");
        read("r.urdf", &text).map(|_| ()).unwrap_err().lines().next().unwrap().to_owned()
    };
    let text = |found: &str, element: &str| {
        format!("text `{found}` inside <{element}>; only elements and comments are allowed")
    };
    assert_eq!(robot(&INERTIAL.replace("</inertial>", "heavy</inertial>")), text("heavy", "inertial"));
    assert_eq!(
        robot("<collision><geometry><sphere radius=\"0\"/></geometry></collision>"),
        "`radius` of sphere is 0; it must be positive"
    );
    assert_eq!(
        robot("<collision><geometry><sphere radius=\"1\"/></geometry><colour/></collision>"),
        "unknown element <colour> in <collision>; there are: origin, geometry, material, verbose, contact_coefficients"
    );
    let world = "<worldbody><body><joint/><geom size=\"1\"/></body></worldbody>";
    let mjcf = |more: &str| {
        let message = read("m.xml", &format!("<mujoco>{world}{more}</mujoco>")).map(|_| ()).unwrap_err();
        message.lines().next().unwrap().to_owned()
    };
    assert_eq!(mjcf("<actuator><motor>--></motor></actuator>"), text("-->", "motor"));
    assert_eq!(mjcf("<actuator>word</actuator>"), text("word", "actuator"));
    assert!(mjcf("<actuator><mottor/></actuator>").starts_with("unknown element <mottor> in <actuator>"));
}

/// An extension of another program may move things: it needs the option; one that is a joint is refused.
#[test]
fn extensions_are_listed_as_what_may_make_forces() {
    let robot = |note: &str| {
        format!(
            "<robot name=\"r\" xmlns:drake=\"d\"><link name=\"a\"/><link name=\"b\">{INERTIAL}</link>{HINGE}{note}</robot>"
        )
    };
    let message = read("r.urdf", &robot("<drake:linear_bushing_rpy>text</drake:linear_bushing_rpy>"));
    assert!(message.unwrap_err().contains("drake:linear_bushing_rpy (an extension of another program)"));
    let message = read("r.urdf", &robot("<drake:joint name=\"s\" type=\"screw\"/>")).unwrap_err();
    assert!(message.starts_with("<drake:joint> is not supported: it moves a link"), "{message}");
}

/// Geoms that shall weigh, and do not, leave the body its `<inertial>`: MuJoCo 4.0.0's masses and heights of the centre of mass.
#[test]
fn an_inertial_gives_way_only_to_geoms_that_weigh() {
    let whole = case("grouprange.xml");
    assert_eq!((whole.character.mass(), left_out(&whole)), (0.9, Vec::<String>::new()));
    let table = [
        ("<geom type='sphere' size='.1' mass='0'/>", 0.9, -0.2),
        ("<geom type='sphere' size='.1' density='0'/><geom type='sphere' size='.1' group='4'/>", 0.9, -0.2),
        ("<geom type='sphere' size='.1' pos='0 0 1'/><geom size='.1' group='4'/>", 4.188790204786391, 1.0),
        ("", 0.9, -0.2),
    ];
    for (geoms, mass, height) in table {
        let text = format!(
            "<mujoco><compiler inertiafromgeom='true' inertiagrouprange='0 2'/><worldbody><body name='b'><joint axis='0 1 0'/><inertial pos='0 0 -.2' mass='0.9' diaginertia='.02 .03 .04'/>{geoms}</body></worldbody></mujoco>"
        );
        let imported = read("m.xml", &text).unwrap();
        let body = &imported.character.bodies[imported.bodies[1].unwrap()];
        assert!((body.mass - mass).abs() < 1e-14 && (body.com.z - height).abs() < 1e-15, "{geoms}");
        assert_eq!(left_out(&imported).len(), usize::from(mass > 1.0), "{geoms}");
    }
}

/// Messages repeat at most 200 characters of a file, whatever stands where.
#[test]
fn messages_repeat_little_of_a_file() {
    let long = "x".repeat(100_000);
    let world = |inside: &str| format!("<mujoco><worldbody>{inside}</worldbody></mujoco>");
    let texts = [
        world(&format!("<{long}/>")),
        world(&format!("<body {long}=\"1\"/>")),
        world(&format!("<body pos=\"{long}\"/>")),
        world(&format!("<body childclass=\"{long}\"/>")),
        world(&format!("<body name=\"{long}\"><geom size=\"1\"/></body>")),
        world(&format!("<body><joint type=\"{long}\"/></body>")),
        world(&format!("<body><geom size=\"1 {long}\"/></body>")),
        world(&format!("<body><geom name=\"{long}\" size=\"-1\"/></body>")),
        format!("<{long}/>"),
        format!("<mujoco><include file=\"{}\"/></mujoco>", "y/".repeat(5000)),
        format!("<mujoco><compiler eulerseq=\"{long}\"/></mujoco>"),
        format!(
            "<mujoco><actuator><motor name=\"{long}\"/></actuator>{}</mujoco>",
            &world("<body><joint/><geom size=\"1\"/></body>")[8..]
        ),
        format!("<mujoco>{}</{long}>", world("")),
    ];
    for text in texts {
        let message = read("m.xml", &text).map(|_| ()).unwrap_err();
        let repeated = message.split(|c| c != 'x').map(str::len).max().unwrap();
        assert!(repeated <= 200 && message.len() < 1500, "{} characters: {message}", message.len());
    }
    let robot = format!(
        "<robot name=\"r\"><link name=\"a\"/><joint name=\"j\" type=\"fixed\"><parent link=\"{long}\"/><child link=\"a\"/></joint></robot>"
    );
    let message = read("r.urdf", &robot).map(|_| ()).unwrap_err();
    assert!(message.len() < 1500, "{message}");
}

/// Names that a format cannot hold, and numbers that single precision cannot, are refused with their place.
#[test]
fn names_and_numbers_that_cannot_be_written_are_refused() {
    let message = |name: &str, text: &str| {
        let message = read(name, text).map(|_| ()).unwrap_err();
        let (said, place) = message.split_once("\n  --> ").unwrap();
        let name = Path::new(place).file_name().unwrap().to_string_lossy().into_owned();
        format!("{said} {name}")
    };
    let world = |inside: &str| format!("<mujoco><worldbody>{inside}</worldbody></mujoco>");
    assert_eq!(
        message("m.xml", &world("<body name=\"a&#10;b\"><geom size=\"1\"/></body>")),
        "the name `a\\nb` has a control character; allowed: letters, digits, signs and blanks m.xml:1:26"
    );
    assert_eq!(
        message("m.xml", &world("<body pos=\"0 1e150 0\"><geom size=\"1\"/></body>")),
        "`pos` of body is 1e150; it must be at most 1e12 in magnitude m.xml:1:26"
    );
    assert_eq!(
        message("m.xml", &world("<body pos=\"0 1e11 0\"><joint/><geom size=\"1\"/></body>")),
        "link `body1` has a length of 1e11 m; it must be at most 1e9 m m.xml:1:9"
    );
    assert_eq!(
        message("r.urdf", "<robot name=\"r\"><link name=\"\"/></robot>"),
        "link `` needs a `name` r.urdf:1:17"
    );
    assert_eq!(
        message("r.urdf", "<robot name=\"r\"><link name=\" \"/></robot>"),
        "the name ` ` begins or ends with a blank; allowed: blanks inside only r.urdf:1:23"
    );
    // an empty name is none in MJCF, and a range without end may be a great number
    let text =
        world("<body name=\"\"><joint type=\"slide\" range=\"-1e300 1e300\"/><geom size=\"1\"/></body>");
    assert_eq!(read("m.xml", &text).unwrap().joints.len(), 1);
}
