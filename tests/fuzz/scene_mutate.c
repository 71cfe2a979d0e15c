/* Changes of a scene's text that leave most of it a scene: lines, numbers, words. */
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t random_state;

static size_t replace(uint8_t *data, size_t size, size_t room, size_t at, size_t old, const void *bytes,
		      size_t count)
{
	if (size - old + count > room)
		return size;
	memmove(data + at + count, data + at + old, size - at - old);
	memcpy(data + at, bytes, count);
	return size - old + count;
}

/* The line that holds `at`, its newline included. */
static size_t line_of(const uint8_t *data, size_t size, size_t at, size_t *length)
{
	size_t first = at, last = at;
	while (first > 0 && data[first - 1] != '\n')
		first--;
	while (last < size && data[last] != '\n')
		last++;
	*length = last - first + (last < size);
	return first;
}

static size_t change_line(uint8_t *data, size_t size, size_t room)
{
	uint8_t copy[1024];
	size_t length, at = line_of(data, size, fuzz_below(&random_state, size), &length);
	if (length > sizeof copy)
		return size;
	memcpy(copy, data + at, length);
	if (fuzz_below(&random_state, 2) == 0)
		size = replace(data, size, room, at, length, "", 0);
	if (size > 0 && fuzz_below(&random_state, 2) == 0) {
		size_t other, to = line_of(data, size, fuzz_below(&random_state, size), &other);
		size = replace(data, size, room, to, 0, copy, length);
	}
	return size;
}

static size_t number_text(char text[40])
{
	switch (fuzz_below(&random_state, 3)) {
	case 0:
		return (size_t)snprintf(text, 40, "%lld", (long long)fuzz_integer(&random_state));
	case 1: {
		double value = fuzz_real(&random_state);
		if (isinf(value)) /* as a number that is none by name */
			return (size_t)snprintf(text, 40, "%s", value > 0 ? "1e999" : "-1e999");
		return (size_t)snprintf(text, 40, "%.17g", value);
	}
	default:
		return (size_t)snprintf(text, 40, "%.3f", (double)fuzz_below(&random_state, 100000) / 1000);
	}
}

static size_t change_number(uint8_t *data, size_t size, size_t room)
{
	char text[40];
	size_t at = fuzz_below(&random_state, size), old = 0;
	for (size_t i = 0; i < size && (data[at] < '0' || data[at] > '9'); i++)
		at = (at + 1) % size;
	while (at + old < size && strchr("0123456789.e-+", data[at + old]) != NULL && data[at + old] != '\0')
		old++;
	return replace(data, size, room, at, old, text, number_text(text));
}

static size_t change_word(uint8_t *data, size_t size, size_t room)
{
	size_t count = 0, length;
	while (fuzz_words[count] != NULL)
		count++;
	const char *word = fuzz_words[fuzz_below(&random_state, count)];
	size_t at = line_of(data, size, fuzz_below(&random_state, size), &length);
	return replace(data, size, room, at, fuzz_below(&random_state, 2) ? length : 0, word, strlen(word));
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed)
{
	random_state = seed;
	if (fuzz_below(&random_state, 3) == 0)
		return LLVMFuzzerMutate(data, size, room);
	for (uint64_t i = 1 + fuzz_below(&random_state, 4); i > 0 && size > 0; i--)
		switch (fuzz_below(&random_state, 3)) {
		case 0:
			size = change_line(data, size, room);
			break;
		case 1:
			size = change_number(data, size, room);
			break;
		default:
			size = change_word(data, size, room);
		}
	return size > 0 ? size : LLVMFuzzerMutate(data, size, room);
}

/* Each of the keys once, so that every part has a line to change; the corpus has the examples. */
size_t fuzz_seed(size_t index, uint8_t *data, size_t room)
{
	static const char *const seeds[] = {
		"scene: 1\nend_time: 1\nobjects:\n  - name: a\n    shape: {sphere: {radius: 1}}\n"
		"    path: {points: [[1, 2]], speed: 3}\n",
		"scene: 1\nstore: s.furrow\ntime_step: 0.02\nend_time: 30\ngravity: 9.81\nspacing: 0.125\n"
		"coordinates: local\nsoil: {name: dry_sand}\nredistribute: {model: box, radius: 2, repetitions: 3}\n"
		"attributes: [dirt]\noutside: stop\nobjects:\n  - name: a\n"
		"    shape: {wheel: {radius: 0.5, width: 0.4, lugs: 0}}\n"
		"    path: {points: [[10, 10], [90, 40]], speed: 5, loop: false}\n    sink: 0.1\n"
		"  - name: b\n    shape: {box: {size: [1, 2, 3]}}\n    path: {file: poses.csv}\n"
		"view:\n  size: [1280, 720]\n  camera: {chase: a, back: 12, up: 5}\n"
		"  effects: [texture, detail, fog, sky, geomorph, skirts]\n  images: 100\n  samples: 4\n"
		"cache: {slots: 256, loaders: 2, prefetch: 1.5}\n"
		SCENE_POSES "t,x,y,z,yaw,pitch,roll\n0,1,2,3,4,5,6\n1,2,3,4,5,6,7\n"
		SCENE_SET "objects.a.sink=0.2\ncache.slots=16\nspacing=null\n",
		"scene: 1\nend_time: 1\nobjects:\n  - {name: a, shape: {sphere: {radius: 1}}, path: {file: poses.csv}}\n"
		"view:\n  size: [64, 48]\n  camera: {over: a, height: 9}\n"
		SCENE_POSES "0,1,2\n1,2,3\n"
		SCENE_SET "view.camera={eye: [1, 2, 3], target: [0, 0, 0]}\n",
		"scene: 1\nend_time: 1\nsoil:\n  map: poses.csv\n  classes:\n    1: dry_sand\n"
		"    2: {name: lete_sand, cohesion: 500}\n  default: lunar\n  rasters: {cohesion: poses.csv, friction_angle: poses.csv}\n"
		"redistribute: {model: scm, iterations: 4, interval: 0.02, depth: 0.5, bulldozing: 0.3}\nobjects:\n"
		"  - name: a\n    shape: {wheel: {radius: 0.5, width: 0.4, lugs: 12, lug_height: 0.02, lug_thickness: 0.03}}\n"
		"    path: {points: [[1, 2]], speed: 3}\n    load: 4000\n    slip: 0.2\n    interface: {friction_angle: 20, adhesion: 300}\n"
		"  - {name: b, shape: {mesh: {file: foot.obj, scale: 2}}, path: {points: [[1, 2]], speed: 3}}\n"
		"output: {forces: 50, delay: 2}\n" SCENE_POSES "any bytes\n" SCENE_SET "soil.classes.3=clayey_38\n",
		"scene: 1\nend_time: 1\nsoil:\n  bekker_kc: 1e3\n  bekker_kphi: 1.5e6\n  bekker_n: 1.1\n  cohesion: 1040\n"
		"  friction_angle: 28\n  janosi_shear: 0.02\n  elastic_stiffness: 4e7\n  damping: 3e4\n  unit_weight: 16e3\n"
		"  repose: 30\n  theta_in: 46\n  theta_out: 25\n  theta_stop: 46\n  roughness: 0.2\n  compression: 0.3\n"
		"redistribute: {model: sumner}\nobjects:\n"
		"  - {name: a, shape: {box: {size: [1, 2, 3]}}, path: {points: [[1, 2]], speed: 3}, sink: 0.1}\n"
		SCENE_SET "redistribute.model=slippage\n",
		/* Mostly poses. */
		"{scene: 1, end_time: 1, objects: [{name: a, shape: {sphere: {radius: 1}}, path: {file: poses.csv}}]}\n"
		SCENE_POSES "t,x,y,z\n0,0,0,0\n1,0,0,0\n2,0,0,0\n3,1,0.5,-0.25\n4,1,1e1,1\n5.5,1,2,3\n6,1,2,3\n7,7,7,7\n",
	};
	if (index >= sizeof seeds / sizeof *seeds)
		return 0;
	size_t size = strlen(seeds[index]);
	fuzz_check(size <= room);
	memcpy(data, seeds[index], size);
	return size;
}
