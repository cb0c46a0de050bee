use super::*;
use cable_robot::sim::PlantParameters;
use cable_robot_fieldbus::simulated::Bench;

#[test]
fn the_parameters_of_a_fieldbus_file_are_those_of_the_bench() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../rigs/can"));
    for name in ["akd.toml", "eight.toml"] {
        let config = Files::read(&folder.join(name)).unwrap().config;
        let bench = Bench::new(config.clone(), PlantParameters::default()).unwrap();
        assert_eq!(controller_parameters(&config), Ok(bench.parameters()), "{name}");
    }
}
