/*
 * What it costs to bring a tile, 257 x 257 R32I, to the GPU and back: by a pointer, and by mapped
 * memory bound as a pixel buffer (gpu_staging, as on hardware); with nothing else to do, or behind a
 * pass of some 20 ms that draws into the tile ("writes"), samples it ("samples"), or has to do with
 * other textures only ("else"). Microseconds: to queue the pass, the call, and from the call until it
 * is over. Medians. "draws": with the raster threads a process that draws keeps.
 */
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "gpu/internal.h"
#include "record.h"

#define RUNS 15
#define SIDE 257u
#define WORK_MS 20.0

static const struct gpu_rect whole = {0, 0, SIDE, SIDE};

/* A pass as long as asked for. */
static const char work_text[] = "#version 450 core\n"
	"layout(binding = 0) uniform isampler2D from;\n"
	"layout(std140, binding = 0) uniform params { int rounds; };\n"
	"layout(location = 0) out int value;\n"
	"void main()\n"
	"{\n"
	"\tvalue = texelFetch(from, ivec2(gl_FragCoord.xy), 0).r;\n"
	"\tfor (int i = 0; i < rounds; i++)\n"
	"\t\tvalue = value * 1664525 + 1013904223;\n"
	"}\n";

enum work { NOTHING, WRITES, SAMPLES, ELSE, WORKS };
static const char *const work_names[] = {"nothing", "writes", "samples", "else"};

struct rig {
	struct gpu *gpu;
	struct gpu_program *program;
	struct gpu_texture *textures[3]; /* 0: the tile */
	struct gpu_target *targets[3];
	struct gpu_staging *staging;
	int32_t *posts;
	int rounds;
	bool draws;
};

static void work_program(struct rig *rig)
{
	static struct shader_text table[3] = {{"work.frag", work_text}};
	for (const struct shader_text *file = gpu_shader_table; file->path != NULL; file++)
		if (strcmp(file->path, "full.vert") == 0)
			table[1] = *file;
	bench_must(gpu_program_get_from(rig->gpu, table, &(struct gpu_program_request){.vertex = "full.vert", .fragment = "work.frag"},
					&rig->program));
}

static void queue_work(struct rig *rig, enum work work)
{
	struct {
		int32_t rounds, unused[3];
	} params = {.rounds = rig->rounds};
	if (work == NOTHING)
		return;
	gpu_pass_run(rig->gpu, &(struct gpu_pass){
		.stage = GPU_PYRAMID,
		.program = rig->program,
		.target = rig->targets[work == WRITES ? 0 : 1],
		.viewport = whole,
		.textures = {rig->textures[work == SAMPLES ? 0 : 2]},
		.params = &params,
		.params_bytes = sizeof params,
	});
}

static double work_ms(struct rig *rig)
{
	gpu_finish(rig->gpu);
	double began = clock_seconds();
	queue_work(rig, WRITES);
	gpu_finish(rig->gpu);
	return (clock_seconds() - began) * 1e3;
}

static void transfer(struct rig *rig, bool upload, bool mapped)
{
	struct gpu_texture *tile = rig->textures[0];
	if (mapped && upload)
		gpu_texture_upload_from(tile, 0, whole, rig->staging, 0);
	else if (mapped)
		gpu_texture_read_into(tile, 0, whole, rig->staging, 0);
	else if (upload)
		gpu_texture_upload(tile, 0, whole, rig->posts);
	else
		gpu_texture_read(tile, 0, whole, rig->posts);
	bench_must(gpu_check(rig->gpu, "bench"));
}

static void measure(struct rig *rig, bool upload, bool mapped, enum work work)
{
	double call[RUNS], over[RUNS], queue[RUNS];
	for (int run = 0; run < RUNS; run++) {
		gpu_finish(rig->gpu);
		double began = clock_seconds();
		queue_work(rig, work);
		double queued = clock_seconds();
		transfer(rig, upload, mapped);
		double called = clock_seconds();
		while (!gpu_staging_idle(rig->staging))
			;
		double ended = clock_seconds();
		queue[run] = (queued - began) * 1e6;
		call[run] = (called - queued) * 1e6;
		over[run] = (ended - queued) * 1e6;
	}
	printf("{\"bench\": \"transfer\", \"what\": \"%s\", \"by\": \"%s\", \"behind\": \"%s\", \"draws\": %s, "
	       "\"queue_us\": %.1f, \"call_us\": %.1f, \"over_us\": %.1f, \"gl\": \"%s\"}\n",
	       upload ? "upload" : "read", mapped ? "mapped" : "pointer", work_names[work], rig->draws ? "true" : "false",
	       bench_median(queue, RUNS), bench_median(call, RUNS), bench_median(over, RUNS),
	       gpu_info(rig->gpu)->renderer);
	fflush(stdout);
	char key[64];
	snprintf(key, sizeof key, "%s.%s.%s.call", upload ? "upload" : "read", mapped ? "mapped" : "pointer", work_names[work]);
	bench_record_add(key, "us", call, RUNS);
	snprintf(key, sizeof key, "%s.%s.%s.over", upload ? "upload" : "read", mapped ? "mapped" : "pointer", work_names[work]);
	bench_record_add(key, "us", over, RUNS);
}

static void rig_init(struct rig *rig)
{
	bench_must(gpu_create(&(struct gpu_params){.draws = rig->draws}, &rig->gpu));
	work_program(rig);
	for (int i = 0; i < 3; i++) {
		struct gpu_texture **texture = &rig->textures[i];
		bench_must(gpu_texture_create(rig->gpu, GPU_R32I, SIDE, SIDE, 0, texture));
		gpu_texture_clear(*texture, 0, whole, 0);
		bench_must(gpu_target_create(rig->gpu, &(struct gpu_attachment){*texture, 0}, 1,
					     (struct gpu_attachment){NULL, 0}, &rig->targets[i]));
	}
	bench_must(gpu_staging_create(rig->gpu, SIDE * SIDE * sizeof *rig->posts, &rig->staging));
	rig->staging->direct = false; /* the other way is "pointer" */
	memset(gpu_staging_bytes(rig->staging), 0, SIDE * SIDE * sizeof *rig->posts);
	rig->posts = mem_calloc(SIDE * SIDE, sizeof *rig->posts);
	if (rig->posts == NULL)
		bench_must(fail_memory("bench"));
	for (rig->rounds = 1024; work_ms(rig) < WORK_MS && rig->rounds < 1 << 30;)
		rig->rounds += rig->rounds / 8;
}

static void rig_finish(struct rig *rig)
{
	mem_free(rig->posts);
	gpu_staging_destroy(rig->staging);
	for (int i = 0; i < 3; i++) {
		gpu_target_destroy(rig->targets[i]);
		gpu_texture_destroy(rig->textures[i]);
	}
	gpu_destroy(rig->gpu);
}

int main(int argc, char **argv)
{
	/* A process settles llvmpipe's threads once: draws or not is an argument. */
	bench_record_begin("transfer", &argc, argv);
	struct rig rig = {.draws = argc > 1 && argv[1][0] == 'd'};
	rig_init(&rig);
	for (int work = NOTHING; work < WORKS; work++)
		for (int way = 0; way < 4; way++)
			measure(&rig, way & 1, way & 2, (enum work)work);
	bench_record_end(gpu_info(rig.gpu)->renderer);
	rig_finish(&rig);
	return 0;
}
