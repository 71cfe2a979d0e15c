/* furrow explain, for a person: sections of lines. Without --all only what a person asks first. */
#include <math.h>
#include <stdio.h>

#include "explain.h"
#include "explain_layout.h"

/* --- what it is over --- */

static void print_head(const struct scene *scene, const struct report_plan *plan)
{
	if (plan->store != NULL)
		printf("%s over %s%s\n", scene->file, plan->store, plan->deformed ? ", which is deformed already" : "");
	else
		printf("%s over no store%s%s%s\n  assumed: one of little relief that is not deformed, with posts and tiles as follow\n",
		       scene->file, plan->missing != NULL ? ": " : "", plan->missing != NULL ? plan->missing : "",
		       plan->missing != NULL ? " is not there" : "");
	printf("  posts %s m apart (level %d) in tiles of %u x %u cells", number_exact(plan->spacing).text, plan->level, plan->cells, plan->cells);
	if (plan->window_tiles > 0)
		printf("; a window touches at most %zu", plan->window_tiles);
	if (plan->batch_windows > 0)
		printf("\n  contacts that share no post are computed together, up to %zu at once; that takes %s more", plan->batch_windows,
		       layout_bytes(plan->batch_bytes).text);
	printf("\n  %s step%s", layout_number((uint64_t)plan->steps).text, plan->steps == 1 ? "" : "s");
	if (plan->pictures > 0)
		printf(", %s picture%s: one every %s steps", layout_number((uint64_t)plan->pictures).text, plan->pictures == 1 ? "" : "s",
		       layout_number((uint64_t)plan->picture_steps).text);
	puts(scene->map ? "; a map at the end" : "");
	if (plan->body_count > 0)
		printf("  the ground is computed by the %s\n", plan->bearing ? "CPU" : scene->compute == SCENE_GPU ? "GPU" : "GPU, or by the CPU where there is no GL");
}

static void print_rasters(const struct report_plan *plan)
{
	if (plan->raster_count > 0)
		puts("\nnumbers of the soil at each post");
	for (int i = 0; i < plan->raster_count; i++) {
		const struct world_raster *raster = &plan->rasters[i];
		char what[200];
		int used = snprintf(what, sizeof what, "  %-17s %.6g to %.6g%s%s in steps of %.4g", raster->key, raster->low, raster->high,
				    raster->unit != NULL ? " " : "", raster->unit != NULL ? raster->unit : "", raster->step);
		if (plan->soils_known)
			snprintf(what + used, sizeof what - (size_t)used, ", along %.3g %% of the paths", 100 * plan->covered[i]);
		layout_row(what, raster->path);
	}
}

static void print_rocks(const struct report_plan *plan)
{
	const struct rocks_spec *rocks = &plan->rocks;
	char text[400], count[80] = "";
	if (!(rocks->cover > 0))
		return;
	puts("\nrocks");
	if (!isnan(plan->rocks_count))
		snprintf(count, sizeof count, ", about %s on the terrain", layout_number((uint64_t)plan->rocks_count).text);
	snprintf(text, sizeof text, "%.3g to %.3g m across, up to %.2g m high, cover %.3g %% of the ground; the law's smaller and larger ones would make it %.3g %%. %.3g a square metre%s",
		 rocks->smallest, rocks->largest, rocks->largest * ROCKS_HEIGHT_MOST, 100 * rocks_cover(rocks, 0), 100 * rocks->cover, rocks_density(rocks), count);
	layout_wrapped(text, 4);
}

/* --- what it takes --- */

/* Bytes of what is made once, whatever the drive does. */
static uint64_t bytes_once(const struct plan *plan)
{
	uint64_t bytes = 0;
	for (size_t i = 0; i < plan->count; i++)
		if (plan->lines[i].unit == PLAN_ONCE && explain_is_memory(&plan->lines[i]))
			bytes += plan->lines[i].bytes;
	return bytes;
}

static void print_memory(const struct scene *scene, const struct report_plan *plan, bool all)
{
	const uint64_t few = plan->most.slots + plan->most.loads + plan->most.queue_few + plan->most.ground;
	char most[860], asked[96] = "", worst[240] = "";
	puts("\nmemory");
	if (all)
		explain_bytes_text(scene, &plan->plan);
	else
		printf("  %s for textures and buffers that are made once\n", layout_bytes(bytes_once(&plan->plan)).text);
	if (scene->memory > 0)
		snprintf(asked, sizeof asked, " of cache.memory: %s", layout_bytes(scene->memory).text);
	if (all) /* far more than any drive needs: it frightens who does not ask */
		snprintf(worst, sizeof worst, "; at most %s, and so within %s (%s), if one step changes very many tiles",
			 layout_bytes(few + plan->most.queue - plan->most.queue_few).text, plan->usable.of, layout_bytes(plan->usable.bytes).text);
	snprintf(most, sizeof most, "for tiles %s%s (%s in %u slots, %s in loads, %s in %u tiles of base heights and those of loaders%s, %s in "
				    "%u changed tiles) while no more changed tiles are on their way%s",
		 layout_bytes(few).text, asked, layout_bytes(plan->most.slots).text, plan->tiles.slots, layout_bytes(plan->most.loads).text,
		 layout_bytes(plan->most.ground).text, plan->tiles.ground, plan->tiles.queries > 0 ? " and queries" : "",
		 layout_bytes(plan->most.queue_few).text, plan->tiles.changed, worst);
	layout_wrapped(most, 4);
	if (plan->all)
		puts("  every tile of the store has a slot: none is loaded ahead, and there are no loaders");
}

static void print_notes(const struct report_plan *plan)
{
	if (plan->note_count > 0)
		puts("\nnotes");
	for (size_t i = 0; i < plan->note_count; i++)
		layout_wrapped(plan->notes[i], 4);
}

/* The last line, which a terminal still shows. */
static void print_end(const struct report_plan *plan, bool all)
{
	char notes[48] = "";
	if (plan->note_count > 0)
		snprintf(notes, sizeof notes, "%zu note%s: see the top", plan->note_count, plan->note_count == 1 ? "" : "s");
	if (!all)
		printf("\n%s%s--all shows effects, planes, programs, passes, threads and statements\n", notes, notes[0] != '\0' ? "; " : "");
	else if (notes[0] != '\0')
		printf("\n%s\n", notes);
}

void explain_text(const struct scene *scene, const struct report_plan *plan, bool all)
{
	print_head(scene, plan);
	print_notes(plan);
	if (all)
		explain_effects_text(scene, plan);
	print_rasters(plan);
	print_rocks(plan);
	explain_soils_text(scene, plan);
	explain_vehicles_text(plan);
	explain_laws_text(scene, plan);
	explain_beside_text(scene, plan);
	explain_sun_text(plan);
	explain_cameras_text(scene, plan);
	if (all) {
		explain_planes_text(scene, plan);
		explain_programs_text(scene, &plan->plan);
		explain_passes_text(scene, plan);
		explain_threads_text(scene, &plan->plan);
		explain_tables_text(scene, &plan->plan);
	} else {
		explain_bodies_text(scene, plan);
	}
	print_memory(scene, plan, all);
	if (all)
		explain_not_run_text(plan);
	print_end(plan, all);
}
