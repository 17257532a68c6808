"""The picture of the skin: dots, and how a contact moves and shades them. Contact mechanics of Hertz, and of Cattaneo and Mindlin."""
import cv2
import numpy as np

from ranges import HEIGHT, WIDTH

CELL = 8        # px between two points of the grid that the displacement is computed on
MARGIN = 80     # px of skin drawn outside of the picture


def hertz(r):
    """Depth of a half space around a Hertz contact of radius 1, as a part of the depth in its centre."""
    inside = 1 - 0.5 * r**2
    far = np.maximum(r, 1.0)
    outside = ((2 - far**2) * np.arcsin(1 / far) + np.sqrt(far**2 - 1)) / np.pi
    return np.where(r < 1, inside, outside)


def light(numbers, margin=0):
    """Logarithm of the light on each pixel: it falls from above and below to the middle, or to both ends, and to one side."""
    n = numbers
    y, x = np.meshgrid(np.arange(-margin, HEIGHT + margin, dtype=np.float32) / (HEIGHT / 2) - 1,
                       np.arange(-margin, WIDTH + margin, dtype=np.float32) / (WIDTH / 2) - 1, indexing="ij")
    return -n["light_fall"] * y**2 + n["light_side"] * (x * np.float32(np.cos(n["light_angle"])) + y * np.float32(np.sin(n["light_angle"])))


def bump_map(rng, length_mm, cells_mm=0.25, size_mm=90):
    """Heights of the object's surface, with standard deviation 1."""
    n = int(size_mm / cells_mm)
    heights = cv2.GaussianBlur(rng.standard_normal((n, n // 2)), (0, 0), length_mm / cells_mm / 2)
    return (heights / heights.std()).astype(np.float32), cells_mm


class Skin:
    def __init__(self, numbers, rng):
        self.numbers = n = numbers
        self.picture = self.draw_dots(rng)
        x = (np.arange(CELL / 2, WIDTH, CELL) - WIDTH / 2) / n["px_per_mm"]
        y = (np.arange(CELL / 2, HEIGHT, CELL) - HEIGHT / 2) / n["px_per_mm"]
        self.x, self.y = np.meshgrid(x.astype(np.float32), y.astype(np.float32))
        angle = rng.uniform(0, 2 * np.pi)
        self.centre = n["patch_off"] * np.array([np.cos(angle) * WIDTH, np.sin(angle) * HEIGHT]) / 2 / n["px_per_mm"]
        turn = rng.uniform(0, np.pi)
        self.dx, self.dy = dx, dy = self.x - self.centre[0], self.y - self.centre[1]
        along, across = dx * np.cos(turn) + dy * np.sin(turn), dy * np.cos(turn) - dx * np.sin(turn)
        self.radius = np.sqrt((along * n["patch_stretch"])**2 + (across / n["patch_stretch"])**2)
        self.border = np.exp(-((dx**2 + dy**2) / n["reach_mm"]**2))
        lift = np.radians(n["mount_angle_deg"])
        self.lift_direction = np.array([np.sin(lift), np.cos(lift)]) * (1 if rng.random() < 0.5 else -1)
        self.bumps, self.bump_cell = bump_map(rng, n["relief_length_mm"])
        rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
        self.columns, self.rows = columns + MARGIN, rows + MARGIN

    def draw_dots(self, rng):
        """Logarithm of the intensity of the skin at rest."""
        n, scale = self.numbers, 4
        width, height = WIDTH + 2 * MARGIN, HEIGHT + 2 * MARGIN
        big = np.zeros((height * scale // 2, width * scale // 2), np.uint8)
        zoom, pitch = scale / 2, n["pitch_mm"] * n["px_per_mm"]
        shift, line = (0.5, 0.866) if n["grid"] == "triangles" else (0.0, 1.0)
        for row in range(int(height / pitch / line) + 2):
            for column in range(int(width / pitch) + 2):
                place = np.array([column + shift * (row % 2), row * line]) + rng.normal(0, n["grid_jitter"], 2)
                radius = n["dot_radius_mm"] * n["px_per_mm"] * rng.uniform(0.93, 1.07)
                if rng.random() >= n["dots_missing"]:
                    cv2.circle(big, tuple(int(v) for v in np.round(place * pitch * zoom * 16)), int(radius * zoom * 16), 255, -1, cv2.LINE_AA, 4)
        dark = cv2.resize(big, (width, height), interpolation=cv2.INTER_AREA).astype(np.float32) / 255
        intensity = 1 - (1 - dark if n["dots"] == "bright" else dark) * (1 - np.exp(-n["dot_contrast"]))
        intensity *= 1 + 0.02 * cv2.GaussianBlur(rng.standard_normal((height, width)), (0, 0), 2.5).astype(np.float32) * 8
        intensity = cv2.GaussianBlur(intensity, (0, 0), n["blur_px"])
        return np.log(np.maximum(intensity, 0.02)) + light(n, MARGIN)

    def relief(self, slid):
        """Height of the object's surface at the grid's points after it slid by `slid` mm."""
        place_x = (self.x + 22.5 - slid * self.lift_direction[0]) / self.bump_cell
        place_y = (self.y + 45 - slid * self.lift_direction[1]) / self.bump_cell
        return cv2.remap(self.bumps, place_x.astype(np.float32), place_y.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)

    def fields(self, depth, shear, limit, gross, slid, turn=0.0, sway=0.0):
        """Displacement [px] towards right and down, and change of the logarithm of the intensity, at the grid's points.

        `turn` [rad]: of the object in the grip; `sway` [mm]: of the whole skin against the camera.
        """
        n = self.numbers
        still = np.zeros_like(self.x)
        swayed = sway * n["px_per_mm"] * self.lift_direction
        if depth <= 1e-7:
            return still + swayed[0], still + swayed[1], still
        part = depth / n["depth_mm"]
        patch = max(0.05, n["patch_mm"] * min(part, 1.2) ** n["patch_growth"])
        r = self.radius / patch
        form = hertz(r) * self.border
        deep = depth * form + n["relief_mm"] * min(1, part) * self.relief(slid) * np.clip(1.3 - r, 0, 1)
        tilt_y, tilt_x = np.gradient(deep, CELL / n["px_per_mm"])
        away_x = self.x * deep / n["distance_mm"] - n["lever_mm"] * tilt_x
        away_y = self.y * deep / n["distance_mm"] - n["lever_mm"] * tilt_y
        pull = shear * form
        if gross < 0.5 and limit > 1e-6 and abs(shear) < limit:
            stick = max(1e-3, np.sqrt(1 - abs(shear) / limit))  # Cattaneo and Mindlin: radius that still sticks
            pull = np.sign(shear) * limit * (hertz(r) - stick**2 * hertz(r / stick)) * self.border
        u = (away_x + pull * self.lift_direction[0] - turn * self.dy * form) * n["px_per_mm"] + swayed[0]
        v = (away_y + pull * self.lift_direction[1] + turn * self.dx * form) * n["px_per_mm"] + swayed[1]
        return u, v, n["shade_per_mm"] * deep + n["shade_per_tilt"] * tilt_y

    def render(self, depth, shear, limit, gross, slid, turn=0.0, sway=0.0):
        """Logarithm of the intensity of each pixel."""
        if depth <= 1e-7 and abs(sway) < 1e-7:
            return self.picture[MARGIN:MARGIN + HEIGHT, MARGIN:MARGIN + WIDTH].copy()
        u, v, shade = (cv2.resize(field.astype(np.float32), (WIDTH, HEIGHT), interpolation=cv2.INTER_LINEAR)
                       for field in self.fields(depth, shear, limit, gross, slid, turn, sway))
        np.subtract(self.columns, u, out=u)
        np.subtract(self.rows, v, out=v)
        shade += cv2.remap(self.picture, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        return shade
