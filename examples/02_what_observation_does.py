"""You learn: how to hold a performance fixed and vary only the way it is seen.

Prints, for one performance, how much of the image the person covers from growing distances, and
from every side at 2 m.
"""

from __future__ import annotations

from affectsim_data import AffectSimDataset, Orbit


def person_share(orbit: Orbit) -> float:
    """Share of the clip's pixels that show the target of the first test episode."""
    dataset = AffectSimDataset(split="test", condition=orbit, instances=True)
    return float((dataset[0]["instances"] == 1).float().mean())


def main() -> None:
    for distance_m in (1.5, 2.0, 3.0, 5.0):
        share = person_share(Orbit(distance_m=distance_m))
        print(f"in front, {distance_m:.1f} m: the person covers {100 * share:5.2f} % of the image")
    for azimuth_deg in (0.0, 90.0, 180.0, 270.0):
        share = person_share(Orbit(distance_m=2.0, azimuth_deg=azimuth_deg))
        print(
            f"2 m, {azimuth_deg:3.0f} degrees: the person covers {100 * share:5.2f} % of the image"
        )


if __name__ == "__main__":
    main()
