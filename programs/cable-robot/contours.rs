//! Lines of equal margin on a grid, by marching squares.

use cable_robot::reach::static_region::Grid;

/// Lines that a picture has at most.
const MOST: f64 = 6.0;

/// Levels between 0 and the greatest margin, N: multiples of one, two or five times a power of ten.
pub fn levels(greatest: f64) -> Vec<f64> {
    if !(greatest > 0.0 && greatest.is_finite()) {
        return vec![];
    }
    let power = 10f64.powf((greatest / MOST).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| greatest / step <= MOST);
    let step = step.unwrap_or(greatest);
    (1..=MOST as usize).map(|k| k as f64 * step).take_while(|level| *level < greatest).collect()
}

/// The pieces of the line on which the margin is `level` (N), each from one point to the next, m.
pub fn line(grid: &Grid, level: f64) -> Vec<[f64; 2]> {
    let mut pieces = vec![];
    for j in 1..grid.y.len() {
        for i in 1..grid.x.len() {
            // Round the cell; where no margin is finite there is no line.
            let round = [(i - 1, j - 1), (i, j - 1), (i, j), (i - 1, j)];
            let corners = round.map(|(i, j)| ([grid.x[i], grid.y[j]], grid.margin[j][i] - level));
            if corners.iter().all(|(_, above)| above.is_finite()) {
                let crossed: Vec<_> =
                    (0..4).filter_map(|k| crossing(corners[k], corners[(k + 1) % 4])).collect();
                pieces.extend(crossed.chunks_exact(2).flatten());
            }
        }
    }
    pieces
}

/// Where the level is passed between two points.
fn crossing((a, of_a): ([f64; 2], f64), (b, of_b): ([f64; 2], f64)) -> Option<[f64; 2]> {
    let share = of_a / (of_a - of_b);
    ((of_a >= 0.0) != (of_b >= 0.0)).then(|| [0, 1].map(|k| a[k] + (b[k] - a[k]) * share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_a_cone_is_its_circle() {
        let x: Vec<f64> = (0..=40).map(|i| f64::from(i) * 0.1 - 2.0).collect();
        let margin = x.iter().map(|y| x.iter().map(|x| 10.0 - 5.0 * x.hypot(*y)).collect()).collect();
        let grid = Grid { y: x.clone(), x, margin };
        let found = line(&grid, 5.0);
        assert!(found.len() > 40);
        assert!(found.iter().all(|[x, y]| (x.hypot(*y) - 1.0).abs() < 5e-3), "{found:?}");
        let length: f64 = found.chunks(2).map(|p| (p[0][0] - p[1][0]).hypot(p[0][1] - p[1][1])).sum();
        assert!((length - std::f64::consts::TAU).abs() < 0.02, "{length}");
    }

    #[test]
    fn levels_are_round_and_below_the_greatest() {
        assert_eq!(levels(52.4), [10.0, 20.0, 30.0, 40.0, 50.0]);
        assert_eq!(levels(9.6), [2.0, 4.0, 6.0, 8.0]);
        assert!(levels(0.0).is_empty() && levels(f64::INFINITY).is_empty());
    }
}
