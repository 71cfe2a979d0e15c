/*
 * Makes the ground's textures. Each is a height field with a brightness and a hue. It is made of noise that repeats, and of strewn
 * blades and stones; the highest one is seen. Then deep places are made darker. Broad differences of brightness are removed, since
 * the eye would find them where a texture repeats.
 */
#include "render/textures.h"

#include <math.h>
#include <string.h>

#define SIZE RENDER_GROUND_SIZE
#define TEXELS ((size_t)SIZE * SIZE)
#define WRAP(i) ((uint32_t)(i) & (SIZE - 1))

/* A layer while it is being made. All arrays are row by row. */
struct ground {
	float *height; /* texels */
	float *tone;   /* brightness, any scale */
	float *hue;    /* 0 to 1 */
	float *spare;
	uint32_t random;
};

static uint32_t hash(uint32_t x, uint32_t y, uint32_t seed)
{
	uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ seed * 0xcb1ab31fu;
	h = (h ^ h >> 15) * 0x2c1b3c6du;
	h = (h ^ h >> 12) * 0x297a2d39u;
	return h ^ h >> 15;
}

static float unit(uint32_t x, uint32_t y, uint32_t seed)
{
	return (float)(hash(x, y, seed) >> 8) * 0x1p-24f;
}

static float roll(struct ground *ground)
{
	return unit(ground->random++, 77, 5);
}

static float mix(float a, float b, float part)
{
	return a + (b - a) * part;
}

static float smooth(float low, float high, float x)
{
	float t = (x - low) / (high - low);
	t = t < 0 ? 0 : t > 1 ? 1 : t;
	return t * t * (3 - 2 * t);
}

/* Adds one octave of value noise, from -amplitude to amplitude. The numbers of cells across and along divide SIZE. */
static void add_noise(float *field, uint32_t across, uint32_t along, float amplitude, uint32_t seed)
{
	float row[SIZE + 1], weight[SIZE];
	uint32_t wide = SIZE / across, tall = SIZE / along, shift_x = hash(seed, 1, 9), shift_y = hash(seed, 2, 9);
	for (uint32_t i = 0; i < wide; i++)
		weight[i] = smooth(0, 1, (float)i / (float)wide);
	for (uint32_t y = 0; y < SIZE; y++) {
		float *out = field + (size_t)WRAP(y + shift_y) * SIZE, up = smooth(0, 1, (float)(y % tall) / (float)tall);
		for (uint32_t i = 0; i <= across; i++)
			row[i] = amplitude * (2 * mix(unit(i % across, y / tall, seed), unit(i % across, (y / tall + 1) % along, seed), up) - 1);
		for (uint32_t i = 0; i < across; i++)
			for (uint32_t k = 0; k < wide; k++)
				out[WRAP(i * wide + k + shift_x)] += mix(row[i], row[i + 1], weight[k]);
	}
}

/* Adds octaves from `from` to `to` cells. Each has `fall` times the amplitude of the one before. */
static void add_clouds(float *field, uint32_t from, uint32_t to, float amplitude, float fall, uint32_t seed)
{
	for (uint32_t cells = from; cells <= to; cells *= 2, amplitude *= fall)
		add_noise(field, cells, cells, amplitude, seed + cells);
}

/* Takes the mean of 2 x radius + 1 texels each way, twice. The weights are nearly a bell curve. */
static void blur(const float *from, float *to, uint32_t radius)
{
	float line[SIZE];
	const float share = 1 / (float)(2 * radius + 1);
	memcpy(to, from, TEXELS * sizeof *to);
	for (int pass = 0; pass < 4; pass++)
		for (uint32_t i = 0; i < SIZE; i++) {
			float *first = pass % 2 ? to + i : to + (size_t)i * SIZE, sum = 0;
			size_t step = pass % 2 ? SIZE : 1;
			for (uint32_t k = 0; k < SIZE; k++)
				line[k] = first[k * step];
			for (uint32_t k = 0; k <= 2 * radius; k++)
				sum += line[WRAP(k - radius)];
			for (uint32_t k = 0; k < SIZE; k++) {
				first[k * step] = sum * share;
				sum += line[WRAP(k + radius + 1)] - line[WRAP(k - radius)];
			}
		}
}

/* Darkens deep places. Texels `deep` below their surroundings get no light from the sky. */
static void darken_deep(struct ground *ground, uint32_t radius, float deep)
{
	blur(ground->height, ground->spare, radius);
	for (size_t i = 0; i < TEXELS; i++) {
		float lift = (ground->height[i] - ground->spare[i]) / deep;
		ground->tone[i] *= 0.25f + 0.75f * smooth(-1.2f, 0.5f, lift);
	}
}

/* Draws a stone or a clod. `grain` makes its outline and surface rough. */
static void strew_stone(struct ground *ground, const float *grain, float radius, float flat, float tone, float hue)
{
	float x = roll(ground) * SIZE, y = roll(ground) * SIZE, turn = 6.2832f * roll(ground);
	float c = cosf(turn), s = sinf(turn), slim = 1 + 0.7f * roll(ground), sink = 0.3f * roll(ground);
	int reach = (int)(radius * 1.25f) + 1, left = (int)x, low = (int)y;
	float lean_x = roll(ground) - 0.5f, lean_y = roll(ground) - 0.5f;
	for (int j = -reach; j <= reach; j++)
		for (int i = -reach; i <= reach; i++) {
			size_t at = (size_t)WRAP(low + j) * SIZE + WRAP(left + i);
			float dx = (float)(left + i) - x, dy = (float)(low + j) - y;
			float u = (dx * c + dy * s) / radius, v = slim * (dy * c - dx * s) / radius;
			float far = (u * u + v * v) * (1 + 0.8f * grain[at]);
			if (far >= 1)
				continue;
			float height = flat * radius * (sqrtf(1 - far) - sink + 0.3f * (u * lean_x + v * lean_y)) + 0.12f * radius * grain[at];
			if (height <= ground->height[at])
				continue;
			ground->height[at] = height;
			ground->tone[at] = tone * (1 + 0.25f * grain[at]);
			ground->hue[at] = hue;
		}
}

/* Draws a blade of grass, from a dark root to a light tip that hangs. */
static void strew_blade(struct ground *ground, float x, float y, float length, float tone, float hue)
{
	float turn = 6.2832f * roll(ground), bend = 2.4f * (roll(ground) - 0.5f), tall = 0.35f + 0.5f * roll(ground);
	int steps = (int)(1.4f * length);
	for (int k = 0; k < steps; k++) {
		float t = (float)k / (float)steps, angle = turn + bend * t, width = 1.5f * (1 - t) + 0.4f;
		float step = length / (float)steps, height = tall * length * t * (1.5f - t);
		x += step * cosf(angle);
		y += step * sinf(angle);
		for (int j = 0; j < 2; j++)
			for (int i = 0; i < 2; i++) {
				float off_x = floorf(x) + (float)i - x, off_y = floorf(y) + (float)j - y;
				size_t at = (size_t)WRAP((int)floorf(y) + j) * SIZE + WRAP((int)floorf(x) + i);
				if (off_x * off_x + off_y * off_y > width || height <= ground->height[at])
					continue;
				ground->height[at] = height;
				ground->tone[at] = tone * (0.45f + 0.75f * t);
				ground->hue[at] = hue * (0.6f + 0.4f * t);
			}
	}
}

static void make_grass(struct ground *ground)
{
	add_clouds(ground->height, 64, 256, 0.9f, 0.7f, 11);
	for (size_t i = 0; i < TEXELS; i++) {
		ground->tone[i] = 0.45f + 0.15f * ground->height[i];
		ground->hue[i] = 0.75f;
	}
	/* Tufts, and shorter grass between them. */
	for (int tuft = 0; tuft < 560; tuft++) {
		float x = roll(ground) * SIZE, y = roll(ground) * SIZE, dry = roll(ground), tall = 0.6f + 0.7f * roll(ground);
		float tone = 0.85f + 0.3f * roll(ground);
		for (int blade = 0; blade < 17; blade++)
			strew_blade(ground, x + 9 * (roll(ground) - 0.5f), y + 9 * (roll(ground) - 0.5f), tall * (8 + 16 * roll(ground)),
				    tone * (0.8f + 0.4f * roll(ground)), smooth(0.35f, 1.0f, 0.6f * dry + 0.5f * roll(ground)));
	}
	for (int blade = 0; blade < 3500; blade++)
		strew_blade(ground, roll(ground) * SIZE, roll(ground) * SIZE, 5 + 11 * roll(ground), 0.7f + 0.5f * roll(ground),
			    smooth(0.2f, 1.1f, roll(ground)));
	darken_deep(ground, 5, 4);
}

static void make_soil(struct ground *ground)
{
	add_clouds(ground->spare, 32, 256, 0.6f, 0.75f, 21);
	float *grain = ground->spare;
	for (size_t i = 0; i < TEXELS; i++) {
		ground->height[i] = 2.6f * grain[i];
		ground->tone[i] = 0.9f + 0.3f * grain[i] + 0.2f * (unit((uint32_t)i, 3, 22) - 0.5f);
		ground->hue[i] = 0.15f + 0.1f * grain[i];
	}
	/* Many small crumbs of the soil's own colour, and a few paler stones. */
	for (int i = 0; i < 4200; i++) {
		float size = roll(ground);
		strew_stone(ground, grain, 1.1f + 8.0f * size * size * size * size * size, 0.6f, 0.8f + 0.35f * roll(ground), 0.05f + 0.3f * roll(ground));
	}
	for (int i = 0; i < 520; i++) {
		float size = roll(ground);
		strew_stone(ground, grain, 1.3f + 6.5f * size * size * size, 0.7f, 0.95f + 0.45f * roll(ground), 0.55f + 0.45f * roll(ground));
	}
	darken_deep(ground, 4, 2.2f);
}

/* Broken rock: large plates between cracks, each with its own tilt, and small plates in them. */
static void add_plates(struct ground *ground, const float *warp, uint32_t cells, float size, uint32_t seed)
{
	const float side = (float)SIZE / (float)cells;
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++) {
			size_t at = (size_t)y * SIZE + x;
			float u = (float)x / side + 0.6f * warp[at], v = (float)y / side + 0.6f * warp[(at + TEXELS / 3 + SIZE / 3) % TEXELS];
			int cell_x = (int)floorf(u), cell_y = (int)floorf(v);
			float nearest = 9, second = 9, to_x = 0, to_y = 0;
			uint32_t whose = 0;
			for (int j = -1; j <= 1; j++)
				for (int i = -1; i <= 1; i++) {
					uint32_t h = hash((uint32_t)(cell_x + i + (int)cells) % cells, (uint32_t)(cell_y + j + (int)cells) % cells, seed);
					float dx = (float)(cell_x + i) + (float)(h & 255) / 255 - u;
					float dy = (float)(cell_y + j) + (float)(h >> 8 & 255) / 255 - v;
					float far = dx * dx + 1.6f * dy * dy;
					second = far < second ? far < nearest ? nearest : far : second;
					whose = far < nearest ? h : whose;
					to_x = far < nearest ? dx : to_x;
					to_y = far < nearest ? dy : to_y;
					nearest = far < nearest ? far : nearest;
				}
			float edge = sqrtf(second) - sqrtf(nearest), crack = smooth(0, 0.08f + 0.10f * fabsf(warp[at]), edge);
			float a = (float)(whose >> 16 & 255) / 255, b = (float)(whose >> 24) / 255;
			float tilt = (a - 0.5f) * to_x + (b - 0.5f) * to_y;
			ground->height[at] += size * (0.9f * a + 1.1f * tilt - 0.55f * (1 - crack));
			ground->tone[at] *= (0.80f + 0.40f * b) * (0.70f + 0.30f * crack);
			ground->hue[at] += 0.35f * (a - 0.5f);
		}
}

static void make_rock(struct ground *ground)
{
	add_clouds(ground->spare, 4, 128, 0.75f, 0.62f, 31);
	add_noise(ground->height, 4, 32, 1.1f, 33); /* beds */
	add_noise(ground->height, 8, 64, 0.8f, 34);
	for (size_t i = 0; i < TEXELS; i++) {
		ground->tone[i] = 1 + 0.05f * ground->height[i];
		ground->hue[i] = 0.5f + 0.12f * ground->height[i];
	}
	add_plates(ground, ground->spare, 6, 10, 35);
	add_plates(ground, ground->spare, 17, 4.5f, 36);
	add_clouds(ground->height, 32, 256, 1.1f, 0.75f, 37);
	for (size_t i = 0; i < TEXELS; i++)
		ground->tone[i] *= 1 + 0.10f * ground->spare[i] + 0.2f * (unit((uint32_t)i, 1, 38) - 0.5f);
	darken_deep(ground, 7, 6);
}

static void make_sand(struct ground *ground)
{
	add_clouds(ground->spare, 4, 32, 1.6f, 0.55f, 41);
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++) {
			size_t at = (size_t)y * SIZE + x;
			float phase = 6.2832f * (7 * (float)x + 27 * (float)y) / SIZE + 1.9f * ground->spare[at];
			float wave = sinf(phase + 0.45f * sinf(phase)), grain = unit(x, y, 42) - 0.5f;
			float strong = 0.75f + 0.25f * ground->spare[(at + TEXELS / 2) % TEXELS];
			ground->height[at] = 1.15f * strong * wave + 0.35f * grain;
			ground->tone[at] = 1 + 0.05f * strong * wave + 0.16f * grain;
			ground->hue[at] = 0.5f + 0.4f * (unit(x, y, 43) - 0.5f) - 0.15f * wave;
		}
}

static void make_snow(struct ground *ground)
{
	add_clouds(ground->height, 8, 64, 2.2f, 0.5f, 51);
	add_noise(ground->height, 16, 32, 1.0f, 52); /* a little longer along the wind; more looked like streaks */
	add_noise(ground->height, 32, 64, 0.5f, 53);
	for (size_t i = 0; i < TEXELS; i++) {
		float grain = unit((uint32_t)i, 2, 54);
		ground->tone[i] = 1 + 0.02f * ground->height[i] + 0.06f * (grain - 0.5f) + (grain > 0.997f ? 0.25f : 0);
		ground->hue[i] = 0.5f;
		ground->height[i] += 0.12f * (grain - 0.5f);
	}
}

/* Makes the layer for ground seen from afar, a third of a metre for each texel: humps and hollows, and the cover on them. */
static void make_far(struct ground *ground)
{
	add_clouds(ground->height, 8, 256, 6, 0.62f, 61);
	add_clouds(ground->spare, 8, 256, 0.42f, 0.84f, 62);
	for (size_t i = 0; i < TEXELS; i++) {
		float crag = 1 - 2.2f * fabsf(ground->spare[i]);
		ground->hue[i] = 0.5f + 0.42f * ground->spare[i];
		ground->tone[i] = 1 + 0.035f * ground->height[i] + 0.16f * crag;
	}
	darken_deep(ground, 10, 9);
}

static uint8_t byte(float value)
{
	float scaled = 255 * value + 0.5f;
	return (uint8_t)(scaled < 0 ? 0 : scaled > 255 ? 255 : scaled);
}

/* Writes the texels: brightness beside its mean over `broad` texels around, hue, and slopes of height whose mean is 0. */
static void write(struct ground *ground, uint32_t broad, float tilt, uint8_t *texels)
{
	double sum = 0;
	blur(ground->tone, ground->spare, broad);
	for (size_t i = 0; i < TEXELS; i++) {
		ground->tone[i] /= 0.25f + 0.75f * ground->spare[i];
		sum += (double)ground->tone[i];
	}
	float scale = 0.5f * (float)((double)TEXELS / sum);
	for (uint32_t y = 0; y < SIZE; y++)
		for (uint32_t x = 0; x < SIZE; x++) {
			const float *here = ground->height + (size_t)y * SIZE;
			float east = here[WRAP(x + 1)] - here[WRAP(x - 1)];
			float north = ground->height[(size_t)WRAP(y + 1) * SIZE + x] - ground->height[(size_t)WRAP(y - 1) * SIZE + x];
			uint8_t *texel = texels + 4 * ((size_t)y * SIZE + x);
			texel[0] = byte(scale * ground->tone[(size_t)y * SIZE + x]);
			texel[1] = byte(ground->hue[(size_t)y * SIZE + x]);
			texel[2] = byte(0.5f + 0.25f * tilt * east);
			texel[3] = byte(0.5f + 0.25f * tilt * north);
		}
}

enum status render_textures_fill(const enum render_ground *kinds, uint32_t layers, uint8_t *texels)
{
	static const struct {
		void (*make)(struct ground *ground);
		uint32_t broad; /* texels */
		float tilt;     /* factor of the slopes */
	} makers[RENDER_GROUNDS] = {
		[RENDER_GRASS] = {make_grass, 40, 0.35f}, [RENDER_SOIL] = {make_soil, 40, 0.7f}, [RENDER_ROCK] = {make_rock, 60, 0.5f},
		[RENDER_SAND] = {make_sand, 60, 0.55f},	  [RENDER_SNOW] = {make_snow, 60, 0.6f}, [RENDER_WIDE] = {make_far, 48, 0.3f},
	};
	float *room = mem_alloc(4 * TEXELS, sizeof *room);
	TRY_MEM(room, "the ground's textures");
	for (uint32_t layer = 0; layer < layers; layer++) {
		enum render_ground kind = kinds[layer];
		struct ground ground = {room, room + TEXELS, room + 2 * TEXELS, room + 3 * TEXELS, (uint32_t)kind << 20};
		memset(room, 0, 4 * TEXELS * sizeof *room);
		makers[kind].make(&ground);
		write(&ground, makers[kind].broad, makers[kind].tilt, texels + 4 * TEXELS * layer);
	}
	mem_free(room);
	return STATUS_OK;
}

void render_textures_halve(uint8_t *texels, uint32_t size, uint32_t squares)
{
	uint8_t *out = texels;
	for (uint32_t square = 0; square < squares; square++)
		for (uint32_t y = 0; y < size; y += 2)
			for (uint32_t x = 0; x < size; x += 2) {
				const uint8_t *from = texels + 4 * (((size_t)square * size + y) * size + x);
				for (int c = 0; c < 4; c++)
					*out++ = (uint8_t)((from[c] + from[c + 4] + from[4 * size + c] + from[4 * size + 4 + c] + 2) >> 2);
			}
}
