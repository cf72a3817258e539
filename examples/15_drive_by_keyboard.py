"""You learn: what a robot sees and may do, by driving one yourself, live in the Rerun viewer.

w goes forward, a and d turn left and right, h hands off, q gives up. The person keeps moving: each
key is a quarter of a second. Without a terminal a short ride is saved for `rerun drive.rrd`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import rerun as rr

from affectsim_data import open_release
from affectsim_data.inspection.trajectory_recording import live_stream
from affectsim_data.render import open_renderer
from affectsim_data.simulation.actions import Action
from affectsim_data.simulation.running import EpisodeRun

KEYS: dict[str, Action] = {
    "w": "move_forward",
    "a": "turn_left",
    "d": "turn_right",
    "h": "hand_off",
    "q": "stop",
}
RIDE = "aawwddwwwwh" + "d" * 8


def pressed() -> Iterator[str]:
    """Keys as they are pressed, without Enter; first a blank, to look around."""
    import termios
    import tty

    before = termios.tcgetattr(sys.stdin)
    try:
        tty.setcbreak(sys.stdin)
        yield " "
        while key := sys.stdin.read(1):
            if key in KEYS:
                yield key
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def main() -> None:
    release = open_release("mini")
    episode = release.episode("test", 0)
    world, navmesh = release.world(episode), release.navmesh(episode.scene_id)
    run = EpisodeRun(episode, world, navmesh, open_renderer(), policy="keyboard")
    by_hand = sys.stdin.isatty() and sys.stdout.isatty()
    stream = rr.RecordingStream("drive")
    if by_hand:
        stream.spawn()
        print(__doc__)
    else:
        stream.save("drive.rrd")
    live = live_stream(stream, episode, world, navmesh=navmesh)
    for key in pressed() if by_hand else [" ", *RIDE]:
        if key != " ":
            run.act(KEYS[key])
        look = run.observe()
        live.at(run.time_s)
        live.place(run.state.position, run.state.yaw, keep_way=True)
        live.see(look.rgb, look.depth)
        live.say("cut short" if look.clipped else KEYS.get(key, "start"))
        if run.outcome is not None:
            break
    print(f"{episode.episode_id}: {run.num_steps} actions, {run.outcome or 'not over yet'}")


if __name__ == "__main__":
    main()
