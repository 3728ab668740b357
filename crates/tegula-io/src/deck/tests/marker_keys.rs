#![allow(clippy::unwrap_used)]

//! Keys of the model file that take the names of markers.

use serde_json::Value;

use super::super::markers::{KEYWORD, Kind};
use super::super::schema::{Wanted, schema, wanted};

/// Keys with three numbers that are neither points nor directions.
const NO_PLACES: [&str; 12] = [
    "value",
    "velocity",
    "angular_velocity",
    "inertia",
    "products_of_inertia",
    "size",
    "stiffness",
    "strain",
    "curvature",
    "membrane",
    "bending",
    "sweep",
];

/// Parts of the model file without points and directions that a marker could give.
const OTHERS: [&str; 2] = [".materials", ".markers"];

/// Each key with three numbers is a point or a direction and takes markers, or is listed as neither.
#[test]
fn all_points_and_directions_take_markers() {
    fn walk(root: &Value, schema: &Value, path: &str, kind: Option<Kind>, marked: &mut Vec<String>) {
        let kind = Kind::of(schema).or(kind);
        match wanted(root, schema) {
            Wanted::Table(table) => {
                let keys = table.keys().map(|key| (key, table.get(key).unwrap()));
                keys.for_each(|(key, schema)| walk(root, schema, &format!("{path}.{key}"), None, marked));
            }
            Wanted::Tagged(branches) => {
                for key in branches.iter().flat_map(|(_, table)| table.keys().map(|key| (key, *table))) {
                    let (key, table) = key;
                    walk(root, table.get(key).unwrap(), &format!("{path}.{key}"), None, marked);
                }
            }
            Wanted::Named(items) => walk(root, items, path, kind, marked),
            Wanted::List(items, low, high) => {
                if !matches!(wanted(root, items), Wanted::Number) {
                    return walk(root, items, path, kind, marked);
                }
                let key = path.rsplit('.').next().unwrap();
                let place = (low, high) == (3, 3)
                    && !NO_PLACES.contains(&key)
                    && !OTHERS.iter().any(|other| path.starts_with(other));
                assert_eq!(place, kind.is_some(), "{path}: is it a point or a direction?");
                marked.extend(kind.map(|kind| format!("{path} {kind:?}")));
            }
            _ => {}
        }
    }
    let root = schema();
    let mut marked = Vec::new();
    walk(&root, &root, "", None, &mut marked);
    for one in [
        ".bodies.at Point",
        ".bodies.axes Direction",
        ".joints.at Point",
        ".joints.axis Direction",
        ".joints.axes Direction",
        ".joints.points Point",
        ".springs.points Point",
        ".springs.across Direction",
        ".torsion_springs.axis Direction",
        ".sensors.at Point",
        ".sensors.points Point",
        ".sensors.axis Direction",
        ".beams.points Point",
        ".beams.direction Direction",
        ".output.points.at Point",
    ] {
        assert!(marked.iter().any(|m| m == one), "{one}: {marked:#?}");
    }
    let places = serde_json::to_string(&root).unwrap();
    assert!(places.contains(KEYWORD) && !super::super::schema_text().contains(KEYWORD));
}
