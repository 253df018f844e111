"""Bytes against quality: IStar and other ways to keep the same pictures, decoded to their full size.

`npm run bench -- rd [PICTURE …]` installs the others and runs this. For each budget the best of each
codec's settings counts, with the picture made smaller first where that helps it. PSNR is over R, G and B
of the whole picture; "wrong" is the share of pixels that are nearer to another of the picture's colours
than to their own. Writes rd.csv and a chart for each picture.
"""

import argparse
import io
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import brotli
import numpy as np
import pillow_jxl  # noqa: F401 (Pillow learns JPEG XL by it)
import resvg_py
import vtracer
from PIL import Image

Image.MAX_IMAGE_PIXELS = None
BUDGETS = [3_000, 6_000, 12_000, 25_000, 50_000]
# What must be reached: (picture, budget, dB). Infinite: without loss.
WANTED = {
    "emblem": {3_000: 33, 6_000: 41, 12_000: math.inf, 25_000: math.inf},
    "map": {3_000: 28.5, 6_000: 31, 12_000: 33.5, 25_000: 37},
}
LOSSLESS = {"emblem": 6_000, "map": 34_000}
# By so much IStar must be better than any codec of pixels, in dB.
AHEAD = 3
PIXEL_CODECS = ["nearest", "linear", "BC1", "JPEG", "JPEG 2000", "WebP", "AVIF", "JPEG XL"]


class Truth:
    """A picture and its colours."""

    def __init__(self, path):
        self.path = path
        self.image = Image.open(path).convert("RGB")
        self.pixels = np.asarray(self.image)
        packed = self.pixels.astype(np.uint32) @ np.array([65536, 256, 1], np.uint32)
        self.colors = np.unique(packed)
        # The nearest of the picture's colours, by the upper six bits of each channel.
        side = (np.arange(64) << 2 | 2).astype(np.int32)
        cube = np.stack(np.meshgrid(side, side, side, indexing="ij"), -1).reshape(-1, 3)
        palette = np.stack([self.colors >> 16, self.colors >> 8 & 255, self.colors & 255], -1).astype(np.int32)
        parts = [((part[:, None] - palette) ** 2).sum(-1).argmin(-1) for part in np.array_split(cube, 64)]
        self.nearest = np.concatenate(parts).astype(np.int16)
        self.own = self.label(self.pixels)

    def label(self, pixels):
        high = pixels >> 2
        return self.nearest[(high[..., 0].astype(np.int32) << 12) | (high[..., 1].astype(np.int32) << 6) | high[..., 2]]

    def figures(self, image):
        """PSNR in dB, and the share of wrong pixels in per cent."""
        pixels = np.asarray(image.convert("RGB"))
        squares = 0.0
        for a, b in zip(np.array_split(pixels, 16), np.array_split(self.pixels, 16)):
            squares += float(((a.astype(np.int32) - b) ** 2).sum())
        mse = squares / self.pixels.size
        psnr = math.inf if mse == 0 else 10 * math.log10(255**2 / mse)
        return psnr, 100 * float((self.label(pixels) != self.own).mean())


def smaller(image, by, filter=Image.Resampling.BOX):
    size = [max(1, math.ceil(side / by)) for side in image.size]
    return image if by == 1 else image.resize(size, filter)


def packed(image, **options):
    out = io.BytesIO()
    image.save(out, **options)
    return out.getvalue()


def pixel_codec(settings, shrinks, filter=Image.Resampling.BICUBIC):
    """Each setting at each size."""

    def points(truth):
        for by in shrinks:
            image = smaller(truth.image, by)
            for options in settings:
                data = packed(image, **options)
                if len(data) <= BUDGETS[-1]:
                    back = Image.open(io.BytesIO(data)).convert("RGB")
                    yield len(data), lambda back=back: back.resize(truth.image.size, filter)

    return points


def nearest(truth):
    for by in [2, 3, 4, 6, 8, 12, 16, 24, 32]:
        image = smaller(truth.image, by, Image.Resampling.NEAREST)
        # Colours of a photograph would not fit; those of a picture of regions do.
        paletted = image.quantize(256, dither=Image.Dither.NONE)
        data = packed(paletted, format="PNG", optimize=True)
        yield len(data), lambda back=paletted.convert("RGB"): back.resize(truth.image.size, Image.Resampling.NEAREST)


def bc1(truth):
    """S3TC's bytes on a GPU: two colours for each 4×4 pixels, and two bits for each."""
    for by in [16, 24, 32, 48, 64, 96]:
        image = smaller(truth.image, by)
        size = [side // 4 * 4 for side in image.size]
        blocks = np.asarray(image.resize(size, Image.Resampling.BOX)).astype(np.float64)
        blocks = blocks.reshape(size[1] // 4, 4, size[0] // 4, 4, 3).transpose(0, 2, 1, 3, 4).reshape(-1, 16, 3)
        middle = blocks.mean(1, keepdims=True)
        # Along the axis of the greatest spread.
        axis = np.linalg.svd(blocks - middle, full_matrices=False)[2][:, :1]
        along = ((blocks - middle) * axis).sum(-1, keepdims=True)
        ends = [middle + part(along, 1)[:, None] * axis for part in (lambda x, a: x.min(a), lambda x, a: x.max(a))]
        grid = np.array([31, 63, 31])
        ends = [np.round(np.clip(end, 0, 255) / 255 * grid) / grid * 255 for end in ends]
        shades = np.concatenate([ends[0] + (ends[1] - ends[0]) * part for part in (0, 1 / 3, 2 / 3, 1)], 1)
        chosen = ((blocks[:, :, None] - shades[:, None]) ** 2).sum(-1).argmin(-1)
        back = np.take_along_axis(shades, chosen[..., None], 1).round().astype(np.uint8)
        back = back.reshape(size[1] // 4, size[0] // 4, 4, 4, 3).transpose(0, 2, 1, 3, 4).reshape(size[1], size[0], 3)
        yield len(blocks) * 8, lambda back=back: Image.fromarray(back).resize(truth.image.size, Image.Resampling.BILINEAR)


def jpeg_2000(truth):
    for budget in BUDGETS:
        # A little less than wanted: rates are kept roughly.
        for part in (0.97, 0.9):
            rate = truth.pixels.size / (part * budget)
            data = packed(truth.image, format="JPEG2000", quality_mode="rates", quality_layers=[rate], irreversible=True)
            if len(data) <= budget:
                yield len(data), lambda data=data: Image.open(io.BytesIO(data))
                break


def traced(truth):
    """vtracer's SVG, packed with brotli, drawn by resvg."""
    source = packed(truth.image, format="PNG")
    for speckle in [1, 2, 4, 8, 16, 32, 64]:
        for mode in ["spline", "polygon"]:
            svg = vtracer.convert_raw_image_to_svg(
                source, "png", colormode="color", hierarchical="stacked", mode=mode, filter_speckle=speckle,
                color_precision=8, layer_difference=0, path_precision=0,
            )
            data = brotli.compress(svg.encode(), quality=9)

            def draw(svg=svg):
                png = bytes(resvg_py.svg_to_bytes(svg_string=svg, width=truth.image.size[0], height=truth.image.size[1]))
                over = Image.new("RGBA", truth.image.size, "white")
                over.alpha_composite(Image.open(io.BytesIO(png)).convert("RGBA"))
                return over

            yield len(data), draw


def istar(command):
    def points(truth):
        with tempfile.TemporaryDirectory() as folder:
            file, back = Path(folder, "x.istar"), Path(folder, "x.png")
            for budget in BUDGETS:
                ask = [command, "encode", truth.path, "-o", file, "--max-bytes", str(budget), "--json"]
                told = subprocess.run(ask, capture_output=True, text=True)
                if told.returncode:
                    continue
                subprocess.run([command, "decode", file, "-o", back], check=True, capture_output=True)
                image = Image.open(back)
                image.load()
                yield file.stat().st_size, lambda image=image: image
                if json.loads(told.stdout)["lossless"]:
                    break

    return points


def codecs(command):
    qualities = lambda format, key, values, **more: [{"format": format, key: value, **more} for value in values]
    return {
        "IStar": istar(command),
        "nearest": nearest,
        "linear": pixel_codec([{"format": "PNG", "optimize": True}], [8, 12, 16, 24, 32, 48, 64], Image.Resampling.BILINEAR),
        "BC1": bc1,
        "JPEG": pixel_codec(qualities("JPEG", "quality", [10, 20, 35, 50, 70, 90], subsampling=0, optimize=True), [2, 4, 8, 16]),
        "JPEG 2000": jpeg_2000,
        "WebP": pixel_codec(qualities("WEBP", "quality", [1, 10, 30, 50, 75], method=4), [1, 2, 4, 8]),
        "AVIF": pixel_codec(qualities("AVIF", "quality", [5, 15, 30, 50, 70], speed=8, subsampling="4:4:4"), [1, 2, 4, 8]),
        "JPEG XL": pixel_codec(qualities("JXL", "quality", [5, 15, 30, 50, 70], effort=4), [1, 2, 4, 8]),
        "vtracer": traced,
    }


def lossless(truth, command):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "x.istar")
        subprocess.run([command, "encode", truth.path, "-o", file, "--lossless"], check=True, capture_output=True)
        ours = file.stat().st_size
    return {
        "IStar": ours,
        "JPEG XL": len(packed(truth.image, format="JXL", lossless=True, effort=7)),
        "WebP": len(packed(truth.image, format="WEBP", lossless=True, method=4)),
        "PNG": len(packed(truth.image.quantize(256, dither=Image.Dither.NONE), format="PNG", optimize=True)),
    }


def chart(name, curves):
    """An SVG of dB over bytes."""
    width, height, left, bottom = 720, 440, 50, 40
    colors = ["#d0103a", "#777", "#aaa", "#b58900", "#268bd2", "#2aa198", "#859900", "#6c71c4", "#cb4b16", "#333"]
    low, high = 16, 50
    x = lambda size: left + (math.log(size) - math.log(2_000)) / math.log(60_000 / 2_000) * (width - left - 130)
    y = lambda psnr: height - bottom - (min(psnr, high) - low) / (high - low) * (height - bottom - 20)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="#fff"/>',
           f'<text x="{left}" y="14">{name}: PSNR in dB (what is without loss at the top) by bytes</text>']
    for psnr in range(low, high + 1, 4):
        out.append(f'<path d="M{left} {y(psnr):.1f}H{width - 130}" stroke="#eee"/><text x="{left - 8}" y="{y(psnr) + 4:.1f}" text-anchor="end">{psnr}</text>')
    for budget in BUDGETS:
        out.append(f'<text x="{x(budget):.1f}" y="{height - bottom + 18}" text-anchor="middle">{budget // 1000} KB</text>')
    for i, (codec, curve) in enumerate(curves.items()):
        points = [(x(b), y(best[0])) for b, best in curve.items() if best]
        color = colors[i % len(colors)]
        if points:
            path = "L".join(f"{px:.1f} {py:.1f}" for px, py in points)
            out.append(f'<path d="M{path}" fill="none" stroke="{color}" stroke-width="{3 if codec == "IStar" else 1.5}"/>')
        out.append(f'<text x="{width - 122}" y="{40 + 18 * i}" fill="{color}">{codec}</text>')
    return "\n".join([*out, "</svg>"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--command", required=True)
    parser.add_argument("--pictures", required=True, help="a folder")
    parser.add_argument("--out", required=True, help="a folder")
    parser.add_argument("names", nargs="+")
    args = parser.parse_args()
    out, sound, rows = Path(args.out), True, ["picture,codec,budget,bytes,psnr,wrong_percent"]
    out.mkdir(parents=True, exist_ok=True)
    for name in args.names:
        truth = Truth(Path(args.pictures, f"{name}.png"))
        curves = {}
        print(f"\n{name:<12}" + "".join(f"{b // 1000:>16} KB" for b in BUDGETS) + "    dB, wrong pixels")
        for codec, points in codecs(args.command).items():
            known = [(size, *truth.figures(draw())) for size, draw in points(truth) if size <= BUDGETS[-1]]
            best = {b: max((p[1:] + (p[0],) for p in known if p[0] <= b), default=None) for b in BUDGETS}
            curves[codec] = best
            cell = lambda p: "–" if p is None else f"{p[0]:.2f} {p[1]:7.3f} %"
            print(f"{codec:<12}" + "".join(f"{cell(best[b]):>19}" for b in BUDGETS), flush=True)
            rows += [f"{name},{codec},{b},{p[2]},{p[0]:.3f},{p[1]:.4f}" for b, p in best.items() if p]
        for budget, wanted in WANTED.get(name, {}).items():
            have = (curves["IStar"][budget] or (0,))[0]
            if have < wanted:
                sound = False
                print(f"rd: {name} at {budget} bytes: {have:.2f} dB, and {wanted} are wanted")
        for budget in BUDGETS:
            ours = (curves["IStar"][budget] or (0,))[0]
            for codec in PIXEL_CODECS:
                theirs = (curves[codec][budget] or (0,))[0]
                if theirs + AHEAD > ours:
                    sound = False
                    print(f"rd: {name} at {budget} bytes: {ours:.2f} dB, and {codec} has {theirs:.2f}")
        sizes = lossless(truth, args.command)
        print("lossless    " + ", ".join(f"{codec} {size}" for codec, size in sizes.items()), flush=True)
        if sizes["IStar"] > LOSSLESS.get(name, math.inf):
            sound = False
            print(f"rd: {name} without loss: {LOSSLESS[name]} bytes are wanted")
        Path(out, f"rd-{name}.svg").write_text(chart(name, curves))
    Path(out, "rd.csv").write_text("\n".join(rows) + "\n")
    print(f"\nrd.csv and charts are in {out}")
    return 0 if sound else 1


if __name__ == "__main__":
    sys.exit(main())
