"use strict";
// Painting of discs: a disc is a stamp, its coverage of the pixels at one of 4 × 4 places within a pixel.

// The colour map cividis at 33 equal steps: readable in grey and for those that see fewer colours.
const CIVIDIS =
  "00224e00285b002e6a0533711a386f273e6e32436d3b496c434e6c4b546c535a6d5a5f6e61656f686a716f70737676767d7c78" +
  "8482798c8878938e789b9476a39a74aba072b4a76fbcae6cc4b468cdbb63d5c25edec958e7d150f0d846f9e03afee838";
const SHADES = 64;
// Above this radius in pixels discs are drawn as circles.
const LARGEST_STAMP = 16;
const PLACES = 4;
const LITTLE = 0x00ff00ff;

// Red, green and blue of cividis at a share of its length.
function cividis(share) {
  const at = share * (CIVIDIS.length / 6 - 1), step = Math.min(Math.floor(at), CIVIDIS.length / 6 - 2);
  return [0, 2, 4].map((part) => {
    const [a, b] = [step, step + 1].map((k) => parseInt(CIVIDIS.slice(6 * k + part, 6 * k + part + 2), 16));
    return Math.round(a + (b - a) * (at - step));
  });
}

// The colours of a scale; its ends are left out where they are too close to the background.
function colourScale(dark) {
  const [low, high] = dark ? [0.24, 1] : [0, 0.94];
  return Array.from({ length: SHADES }, (_, k) => cividis(low + (high - low) * k / (SHADES - 1)));
}

// Colours as pixels of ImageData.
function asPixels(colours) {
  return Uint32Array.from(colours, ([r, g, b]) => (255 << 24 | b << 16 | g << 8 | r) >>> 0);
}

// Coverage of the pixels by a disc, in 256ths, at the 16 places of its centre within a pixel. The rim is mixed with the
// background, so that discs that touch stay apart.
function makeStamps(radius) {
  const half = Math.ceil(radius + 1), size = 2 * half + 1;
  const rim = Math.min(1, Math.max(0, (radius - 1) / 3)) / 3;
  const thin = radius < 0.5 ? (2 * radius) ** 2 : 1, edge = Math.max(radius, 0.5) + 0.5;
  const masks = [];
  for (let place = 0; place < PLACES * PLACES; place++) {
    const mask = new Uint16Array(size * size);
    const dx = (place % PLACES + 0.5) / PLACES, dy = (Math.floor(place / PLACES) + 0.5) / PLACES;
    for (let k = 0; k < mask.length; k++) {
      const out = edge - Math.hypot(k % size - half + 0.5 - dx, Math.floor(k / size) - half + 0.5 - dy);
      const inside = Math.min(1, Math.max(0, out));
      mask[k] = Math.round(256 * thin * inside * (1 - rim * Math.min(1, Math.max(0, 2 - out))));
    }
    masks.push(mask);
  }
  return { half, size, masks };
}

// A picture of discs: `paint` puts one at a place in pixels, with an index into `colours`.
class Painter {
  constructor(width, height) {
    this.image = new ImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.stamps = new Map();
  }

  // The stamps of a radius, to an eighth of a pixel.
  stampsOf(radius) {
    const key = Math.max(1, Math.round(8 * radius));
    if (!this.stamps.has(key)) this.stamps.set(key, makeStamps(key / 8));
    return this.stamps.get(key);
  }

  paint(x, y, radius, colour) {
    const { half, size, masks } = this.stampsOf(radius), { width, height } = this.image;
    const column = Math.floor(x), row = Math.floor(y);
    const mask = masks[Math.floor(PLACES * (y - row)) * PLACES + Math.floor(PLACES * (x - column))];
    const left = column - half, top = row - half, from = Math.max(0, -left), to = Math.min(size, width - left);
    const last = Math.min(size, height - top), red = colour & LITTLE, green = colour & 0xff00;
    for (let j = Math.max(0, -top); j < last; j++) {
      let pixel = (top + j) * width + left + from;
      for (let k = j * size + from; k < j * size + to; k++, pixel++) {
        const cover = mask[k];
        if (cover === 256) this.pixels[pixel] = colour;
        else if (cover) this.pixels[pixel] = mixed(this.pixels[pixel], red, green, cover);
      }
    }
  }
}

// A pixel with another colour over it, which covers so many 256ths.
function mixed(under, red, green, cover) {
  const rest = 256 - cover;
  const outer = ((under & LITTLE) * rest + red * cover) >>> 8 & LITTLE;
  const inner = ((under & 0xff00) * rest + green * cover) >>> 8 & 0xff00;
  return (0xff000000 | outer | inner) >>> 0;
}
