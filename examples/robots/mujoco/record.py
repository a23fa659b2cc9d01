"""Records the path of the hand as a demonstration for `longstep teach`. See docs/guide/teaching.md."""

import random

RATE = 30


class Recorder:
    """Writes the hand at 30 Hz of simulated time, with noise if wanted."""

    def __init__(self, path, noise, seed):
        self.file = open(path, "w", encoding="utf-8")
        self.file.write("t,hand,x,y,z,grip,step\n")
        self.noise, self.random = noise, random.Random(seed)
        self.step, self.frames = None, 0

    def begin(self, step):
        """Begins a step: the frames from now on show it."""
        self.step = step

    def sample(self, world):
        """Writes a frame if one is due. Nothing is shown before the first step."""
        time = world.data.time
        if self.step is None or time * RATE < self.frames:
            return
        self.frames = int(time * RATE) + 1
        x, y, z = (value + self.random.gauss(0, self.noise) for value in world.hand())
        grip = 0 if world.held is None else 1
        self.file.write(f"{time:.4f},right,{x:.5f},{y:.5f},{z:.5f},{grip},{self.step}\n")

    def end(self):
        self.file.flush()
