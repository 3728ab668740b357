use super::*;
use crate::out::vtu_file::VtuFile;

#[test]
fn bounds_and_ranges_skip_what_is_not_finite() {
    let (mut bounds, mut range) = (Bounds::default(), Range::default());
    for x in [[1.0, 2.0, 3.0], [f64::NAN, -1.0, f64::INFINITY], [0.0, 0.0, 5.0]] {
        bounds.add(&x);
        x.iter().for_each(|value| range.add(*value));
    }
    let corners = bounds.corners();
    assert_eq!((corners[0], corners[7]), ([0.0, -1.0, 3.0], [1.0, 2.0, 5.0]));
    assert_eq!(range.0, Some([-1.0, 5.0]));
}

#[test]
fn endings_name_the_kind_of_a_film() {
    let of = |name: &str| Encoding::of(Path::new(name));
    assert_eq!(
        [of("a.gif"), of("b/A.GIF"), of("a.mp4")],
        [Some(Encoding::Gif), Some(Encoding::Gif), Some(Encoding::Mp4)]
    );
    assert_eq!([of("a.png"), of("a"), of("gif")], [None; 3]);
}

#[test]
fn a_folder_without_results_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.png");
    assert!(still(folder.path(), &Drawing::default(), &file).is_err());
    assert!(!file.exists() && VtuFile::open(&file).is_err());
}
