"""Writes a recording for `longstep teach` from a video of a person: the wrist, the elbow and the shoulder of an arm.

One camera measures no distance. Without --depth, MediaPipe's guess of metric positions around the hips is written, in the
frame `hips`: directions and shapes are usable, sizes and places are not. With --depth and --camera, positions are measured,
in the frame `camera`; --to-world makes them positions of the robot's frame. See docs/guide/teaching.md.
"""

import argparse
import csv
import json
import math
import os
import sys

import cv2
import numpy as np

# Landmarks of MediaPipe's pose: shoulder, elbow and wrist.
ARMS = {"left": (11, 13, 15), "right": (12, 14, 16)}
# Landmarks of its hand: the knuckle and the tip of the four fingers.
FINGERS = ((5, 8), (9, 12), (13, 16), (17, 20))
COLUMNS = ["t", "hand", "x", "y", "z", "grip", "elbow_x", "elbow_y", "elbow_z", "shoulder_x", "shoulder_y", "shoulder_z",
           "grasp", "frame"]


def upright(point):
    """From a camera's axes (x right, y down, z forward) to those of a recording (x right, y forward, z up)."""
    x, y, z = point
    return np.array([x, z, -y])


def closure(landmarks):
    """How far a hand is closed, from 0 to 1: the fingertips come back to the knuckles."""
    points = np.array([(own.x, own.y, own.z) for own in landmarks])
    palm = np.linalg.norm(points[9] - points[0])
    reach = np.mean([np.linalg.norm(points[tip] - points[0]) for _, tip in FINGERS]) / max(palm, 1e-6)
    # About 1.9 palms for an open hand, 1.0 for a fist.
    return float(np.clip((1.9 - reach) / 0.9, 0, 1))


class Depth:
    """Measured positions: depth pictures in millimetres, aligned with the video, and the camera's focal lengths and centre."""

    def __init__(self, folder, camera, to_world):
        self.files = [os.path.join(folder, name) for name in sorted(os.listdir(folder)) if name.endswith(".png")]
        self.camera, self.to_world = camera, to_world

    def points(self, index, landmarks, size):
        if index >= len(self.files):
            return None
        picture = cv2.imread(self.files[index], cv2.IMREAD_UNCHANGED)
        if picture is None or picture.dtype != np.uint16 or picture.shape[:2] != size:
            raise SystemExit(f"error: {self.files[index]} is no 16-bit picture of the video's size")
        found = [self.point(picture, own) for own in landmarks]
        return None if any(point is None for point in found) else found

    def point(self, picture, landmark):
        height, width = picture.shape
        u, v = landmark.x * width, landmark.y * height
        if not (2 <= u < width - 2 and 2 <= v < height - 2):
            return None
        near = picture[int(v) - 2 : int(v) + 3, int(u) - 2 : int(u) + 3]
        near = near[near > 0]
        if near.size == 0:
            return None
        z = float(np.median(near)) / 1000
        fx, fy, cx, cy = self.camera
        point = np.array([(u - cx) * z / fx, (v - cy) * z / fy, z, 1.0])
        return upright(point[:3]) if self.to_world is None else (self.to_world @ point)[:3]


def rows(options):
    import mediapipe

    video = cv2.VideoCapture(options.video)
    rate = video.get(cv2.CAP_PROP_FPS)
    if not video.isOpened() or not rate or math.isnan(rate):
        raise SystemExit(f"error: {options.video} is no video")
    to_world = None
    if options.to_world:
        with open(options.to_world, encoding="utf-8") as file:
            to_world = np.array(json.load(file), float)
        if to_world.shape != (4, 4):
            raise SystemExit(f"error: {options.to_world} is no matrix of four by four numbers")
    depth = Depth(options.depth, options.camera, to_world) if options.depth else None
    frame = "hips" if depth is None else "camera" if to_world is None else "world"
    solutions = mediapipe.solutions
    with solutions.pose.Pose(model_complexity=1) as pose, solutions.hands.Hands(max_num_hands=2) as hands:
        index = -1
        while True:
            is_read, picture = video.read()
            if not is_read:
                return
            index += 1
            colours = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
            body, found = pose.process(colours), hands.process(colours)
            if body.pose_landmarks is None:
                continue
            on_picture = [body.pose_landmarks.landmark[own] for own in ARMS[options.hand]]
            if min(own.visibility for own in on_picture) < 0.5:
                continue
            if depth is None:
                around = [body.pose_world_landmarks.landmark[own] for own in ARMS[options.hand]]
                points = [upright((own.x, own.y, own.z)) for own in around]
            else:
                points = depth.points(index, on_picture, picture.shape[:2])
            if points is None:
                continue
            shoulder, elbow, wrist = (point.tolist() for point in points)
            grip = ""
            for landmarks in found.multi_hand_landmarks or []:
                at = landmarks.landmark[0]
                if math.hypot(at.x - on_picture[2].x, at.y - on_picture[2].y) < 0.1:
                    grip = f"{closure(landmarks.landmark):.2f}"
            numbers = [f"{value:.5f}" for value in wrist], [f"{value:.5f}" for value in elbow + shoulder]
            yield [f"{index / rate:.4f}", options.hand, *numbers[0], grip, *numbers[1], options.grasp, frame]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("video")
    parser.add_argument("output", help="the recording, a .csv file")
    parser.add_argument("--hand", choices=("left", "right"), default="right")
    parser.add_argument("--grasp", default="", help="the kind of grasp, which a video does not show: power, precision, hook")
    parser.add_argument("--depth", metavar="FOLDER", help="depth pictures (16-bit PNG, millimetres), one a frame")
    parser.add_argument("--camera", type=float, nargs=4, metavar=("FX", "FY", "CX", "CY"), help="the camera, in pixels")
    parser.add_argument("--to-world", metavar="FILE.json", help="a 4x4 matrix from the camera's axes to the robot's frame")
    options = parser.parse_args()
    if bool(options.depth) != bool(options.camera) or options.to_world and not options.depth:
        parser.error("--depth and --camera belong together, and --to-world needs them")
    written = 0
    with open(options.output, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for row in rows(options):
            writer.writerow(row)
            written += 1
    if written == 0:
        raise SystemExit("error: no arm was found in the video; show shoulder, elbow and hand")
    print(f"{written} frames", file=sys.stderr)


if __name__ == "__main__":
    main()
