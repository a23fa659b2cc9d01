"""A strip of pictures: the scene after each step, with the step under it. Needs a GL without a screen (EGL or OSMesa)."""

import mujoco
from PIL import Image, ImageDraw

WIDTH, HEIGHT, CAPTION, COLUMNS = 320, 240, 22, 4
# More steps than this are not pictured.
LIMIT = 100


class Strip:
    """Collects pictures and writes them as one image."""

    def __init__(self, world, file):
        self.world, self.file, self.pictures = world, file, []
        self.renderer = mujoco.Renderer(world.model, HEIGHT, WIDTH)
        self.camera = mujoco.MjvCamera()
        width = world.scene.width
        self.camera.lookat[:] = [width / 2, -0.15, 0.4]
        self.camera.distance = max(1.9, width + 0.5)
        self.camera.azimuth, self.camera.elevation = 105, -22

    def add(self, caption):
        if len(self.pictures) < LIMIT:
            self.renderer.update_scene(self.world.data, self.camera)
            self.pictures.append((caption, self.renderer.render()))

    def save(self):
        rows = -(-len(self.pictures) // COLUMNS)
        columns = min(COLUMNS, len(self.pictures))
        strip = Image.new("RGB", (columns * WIDTH, rows * (HEIGHT + CAPTION)), "white")
        draw = ImageDraw.Draw(strip)
        for number, (caption, picture) in enumerate(self.pictures):
            x, y = number % COLUMNS * WIDTH, number // COLUMNS * (HEIGHT + CAPTION)
            strip.paste(Image.fromarray(picture), (x, y))
            draw.text((x + 6, y + HEIGHT + 4), caption, fill="black")
        strip.save(self.file, format="PNG", optimize=True)
