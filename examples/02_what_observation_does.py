"""You learn: how to hold a performance fixed and vary only the way it is seen.

Prints, for one performance, how much of the image the person covers from growing distances, and
from every side at 2 m. Walls may allow less than was asked for: `distance_m` says what was.
"""

from __future__ import annotations

from affectsim_data import AffectSimDataset, Clip, Orbit


def roomiest() -> int:
    """The test episode that can be seen from farthest in front."""
    small = Clip(num_frames=1, width=16, height=16)
    dataset = AffectSimDataset(split="test", condition=Orbit(distance_m=6.0), clip=small)
    return max(range(len(dataset)), key=lambda i: float(dataset[i]["distance_m"].mean()))


def report(orbit: Orbit, index: int) -> None:
    """One line about an episode seen from there."""
    sample = AffectSimDataset(split="test", condition=orbit, instances=True)[index]
    share = 100 * (sample["instances"] == 1).float().mean().item()
    reached = sample["distance_m"].mean().item()
    print(
        f"{orbit.azimuth_deg:3.0f} degrees, {orbit.distance_m:.1f} m asked, {reached:.1f} m "
        f"reached: the person covers {share:5.2f} % of the image"
    )


def main() -> None:
    index = roomiest()
    for distance_m in (1.5, 2.0, 3.0, 5.0):
        report(Orbit(distance_m=distance_m), index)
    for azimuth_deg in (90.0, 180.0, 270.0):
        report(Orbit(distance_m=2.0, azimuth_deg=azimuth_deg), index)


if __name__ == "__main__":
    main()
