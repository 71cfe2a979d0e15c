/* Sources of several SRS, spacings and units as one terrain; windows; what is kept as it is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <cpl_conv.h>

#include "raster.h"
#include "../support/program.h"

#define TRUTH "EPSG:32633"

/* A plane over UTM 33N. */
static double truth(double x, double y)
{
	return 300 + 0.02 * (x - 500000) - 0.03 * (y - 5000000);
}

/* A raster of the plane in any SRS, in metres times `scale`; `more` metres above it. */
struct view {
	struct made made;
	double scale, more;
};

static const struct view *viewed;

static double plane_at(int x, int y)
{
	const struct made *made = &viewed->made;
	double at[2] = {made->west + (x + 0.5) * made->dx, made->north - (y + 0.5) * made->dy};
	static char wkt[8192];
	OGRSpatialReferenceH to = OSRNewSpatialReference(NULL);
	char *text = NULL;
	assert_int_equal(OSRSetFromUserInput(to, TRUTH), OGRERR_NONE);
	assert_int_equal(OSRExportToWkt(to, &text), OGRERR_NONE);
	snprintf(wkt, sizeof wkt, "%s", text);
	CPLFree(text);
	OSRDestroySpatialReference(to);
	assert_int_equal(dem_transform(made->srs, wkt, 1, &at[0], &at[1]), STATUS_OK);
	return (truth(at[0], at[1]) + viewed->more) / viewed->scale;
}

static void make_view(struct view *view)
{
	view->made.height_of = plane_at;
	view->made.type = GDT_Float32;
	viewed = view;
	make(&view->made);
}

static struct view metres(double dx)
{
	return (struct view){{.name = "metres.tif", .srs = TRUTH, .width = 24, .height = 20, .west = 500000, .north = 5000000,
			      .dx = dx, .dy = dx}, 1, 0};
}

/* About 40 x 30 posts around the former, in degrees and feet. */
static struct view degrees(void)
{
	return (struct view){{.name = "degrees.tif", .srs = "EPSG:4326", .width = 40, .height = 30, .west = 14.997, .north = 45.156,
			      .dx = 0.0003, .dy = 0.0003, .unit = "ft"}, 0.3048, 0};
}

static struct view next_zone(void)
{
	return (struct view){{.name = "zone34.tif", .srs = "EPSG:32634", .width = 30, .height = 30, .west = 29100, .north = 5011700,
			      .dx = 30, .dy = 30}, 1, 0};
}

static void three_systems_and_units_become_one_plane(void **state)
{
	for (double dx = 5; dx <= 45; dx *= 3) {
		struct view views[3] = {metres(dx), degrees(), next_zone()};
		const char *sources[3];
		for (int i = 0; i < 3; i++) {
			make_view(&views[i]);
			sources[i] = in_folder(views[i].made.name);
		}
		struct dem_params params = params_of(sources, 3);
		struct dem *dem = open_with(&params);
		const struct dem_info *info = dem_info(dem);
		assert_non_null(strstr(info->srs, "UTM zone 33N"));
		/* The first one's posts are kept where they are finest. */
		double own = dx < 27 ? dx : 27.9; /* of the degrees */
		assert_true(fabs(info->spacing - own) < 0.5);
		assert_true(info->overlap_posts > 0 && info->overlap_difference < 0.02);
		int64_t holes = 0, off = 0, posts = info->width * info->height;
		double *heights = mem_alloc((size_t)posts, sizeof *heights);
		assert_int_equal(dem_read(dem, (struct post_rect){0, 0, info->width, info->height}, heights), STATUS_OK);
		for (int64_t i = 0; i < posts; i++) {
			double x = info->origin[0] + (double)(i % info->width) * info->spacing;
			double y = info->origin[1] + (double)(i / info->width) * info->spacing;
			holes += isnan(heights[i]);
			/* Up to half a post of its source beyond the outer ones a height is that of the edge. */
			off += isnan(heights[i]) ? 0 : !(fabs(heights[i] - truth(x, y)) <= 0.02);
			assert_true(isnan(heights[i]) || fabs(heights[i] - truth(x, y)) < 0.036 * 45);
		}
		assert_true(holes < posts * 9 / 10 && off < (posts - holes) / 10);
		mem_free(heights);
		dem_close(dem);
	}
}

/* Returns the height at a place of the truth's SRS, which is a post. */
static double height_over(struct dem *dem, double x, double y)
{
	const struct dem_info *info = dem_info(dem);
	double column = (x - info->origin[0]) / info->spacing, row = (y - info->origin[1]) / info->spacing;
	assert_true(fabs(column - rint(column)) < 1e-6 && fabs(row - rint(row)) < 1e-6);
	return height_at(dem, llrint(column), llrint(row));
}

static void of_two_systems_the_first_named_wins(void **state)
{
	struct view a = metres(10), b = degrees();
	b.more = 50;
	make_view(&a);
	make_view(&b);
	const char *sources[] = {in_folder("metres.tif"), in_folder("degrees.tif")};
	struct dem_params params = params_of(sources, 2);
	struct dem *dem = open_with(&params);
	assert_true(dem_info(dem)->overlap_posts > 20 && dem_info(dem)->overlap_differing == dem_info(dem)->overlap_posts);
	assert_true(fabs(dem_info(dem)->overlap_difference - 50) < 0.02);
	for (int i = 0; i < 20; i++) { /* to the outermost post the first's own bits, since its posts are kept */
		double x = 500005 + 10 * i, y = 5000000 - 5 - 10 * i;
		assert_true(height_over(dem, x, y) == (double)(float)truth(x, y));
	}
	assert_true(fabs(height_over(dem, 500275, 4999895) - truth(500275, 4999895) - 50) < 0.02);
	dem_close(dem);
	const char *turned[] = {sources[1], sources[0]};
	params = params_of(turned, 2);
	params.t_srs = TRUTH;
	dem = open_with(&params);
	assert_true(dem_info(dem)->spacing == 10);
	assert_true(fabs(height_over(dem, 500105, 4999895) - truth(500105, 4999895) - 50) < 0.02);
	dem_close(dem);
}

/* Where the first source ends, posts half a post beyond it are the second's, not the first's edge. */
static void an_edge_is_not_drawn_out_over_another_source(void **state)
{
	struct view a = metres(10), b = metres(10);
	a.made.width = 5;
	b.made.name = "beside.tif";
	b.made.west += 3; /* the same posts nowhere */
	make_view(&a);
	make_view(&b);
	const char *sources[] = {in_folder("metres.tif"), in_folder("beside.tif")};
	struct dem_params params = params_of(sources, 2);
	for (double spacing = 1; spacing <= 4; spacing *= 2) {
		params.spacing = spacing;
		struct dem *dem = open_with(&params);
		for (double x = 500016; x < 500200; x += spacing) {
			double column = (x - dem_info(dem)->origin[0]) / spacing, y = dem_info(dem)->origin[1] + 8 * spacing;
			double found = height_at(dem, (int64_t)column, 8), at = dem_info(dem)->origin[0] + floor(column) * spacing;
			assert_true(fabs(found - truth(at, y)) < 1e-3);
		}
		dem_close(dem);
	}
}

static void a_window_is_cut_in_any_system(void **state)
{
	struct view a = metres(10);
	make_view(&a);
	const char *path = in_folder("metres.tif");
	struct dem_params params = params_of(&path, 1);
	params.has_window = true;
	memcpy(params.window, (double[]){500042, 4999850, 500151, 4999960}, sizeof params.window);
	struct dem *dem = open_with(&params);
	assert_true(dem_info(dem)->origin[0] == 500045 && dem_info(dem)->origin[1] == 4999855);
	assert_int_equal(dem_info(dem)->width, 11);
	assert_int_equal(dem_info(dem)->height, 11);
	for (int i = 0; i < 11; i++)
		assert_true(height_at(dem, i, 3) == (double)(float)truth(500045 + 10 * i, 4999885));
	dem_close(dem);
	/* The same in degrees: at 15 degrees east, UTM 33N is true to north. */
	params.window_srs = "EPSG:4326";
	memcpy(params.window, (double[]){15.0005, 45.1517, 15.0018, 45.1529}, sizeof params.window);
	dem = open_with(&params);
	double corner[2] = {15.0005, 45.1517};
	assert_int_equal(dem_transform("EPSG:4326", dem_info(dem)->srs, 1, &corner[0], &corner[1]), STATUS_OK);
	assert_true(dem_info(dem)->origin[0] >= corner[0] - 1e-3 && dem_info(dem)->origin[0] < corner[0] + 10);
	assert_true(dem_info(dem)->origin[1] >= corner[1] - 1e-3 && dem_info(dem)->origin[1] < corner[1] + 10);
	dem_close(dem);
	memcpy(params.window, (double[]){20, 45, 21, 46}, sizeof params.window);
	assert_refused(&params, STATUS_INPUT, "no source lies there");
	params.window_srs = "nonsense";
	assert_refused(&params, STATUS_INPUT, "nonsense");
	params.window_srs = NULL;
	memcpy(params.window, (double[]){4, 3, 2, 1}, sizeof params.window);
	assert_refused(&params, STATUS_USAGE, "W,S,E,N");
	params.has_window = false;
	params.window_srs = "EPSG:4326";
	assert_refused(&params, STATUS_USAGE, "no window");
}

/* Web Mercator at 45 degrees: 1.41 times too large, and kept only if that is asked. */
static void source_keeps_the_posts_of_any_metric_system(void **state)
{
	struct made made = utm("mercator.tif");
	made.srs = "EPSG:3857";
	made.west = 1669792;
	made.north = 5640000;
	make(&made);
	const char *path = in_folder("mercator.tif");
	struct dem_params params = params_of(&path, 1);
	params.t_srs = "source";
	struct dem *dem = open_with(&params);
	assert_true(dem_info(dem)->spacing == 10 && dem_info(dem)->whole && dem_info(dem)->origin[0] == made.west + 5);
	assert_non_null(strstr(dem_info(dem)->srs, "Pseudo-Mercator"));
	for (int x = 0; x < 9; x++)
		assert_true(height_at(dem, x, 2) == ramp(x, 4));
	dem_close(dem);
	made = utm("geographic.tif");
	made.srs = "EPSG:4326";
	made.west = 15;
	made.north = 45;
	made.dx = made.dy = 0.001;
	make(&made);
	path = in_folder("geographic.tif");
	params = params_of(&path, 1);
	params.t_srs = "source";
	assert_refused(&params, STATUS_INPUT, "in degrees");
	made = utm("feet.tif");
	made.srs = "EPSG:2229";
	made.west = 6500000;
	made.north = 1850000;
	make(&made);
	path = in_folder("feet.tif");
	params = params_of(&path, 1);
	params.t_srs = "source";
	assert_refused(&params, STATUS_INPUT, "metres");
}

static void wkt_may_begin_with_a_new_line(void **state)
{
	struct made made = utm("newline.tif");
	make(&made);
	OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
	char *wkt = NULL, text[4096];
	assert_int_equal(OSRImportFromEPSG(srs, 32634), OGRERR_NONE);
	assert_int_equal(OSRExportToPrettyWkt(srs, &wkt, 0), OGRERR_NONE);
	snprintf(text, sizeof text, "\n  %s\n", wkt);
	CPLFree(wkt);
	OSRDestroySpatialReference(srs);
	const char *path = in_folder("newline.tif");
	struct dem_params params = params_of(&path, 1);
	params.t_srs = text;
	struct dem *dem = open_with(&params);
	assert_non_null(strstr(dem_info(dem)->srs, "UTM zone 34N"));
	dem_close(dem);
}

/* Posts on both sides of 180 degrees. */
static void a_source_across_the_date_line_has_no_gap(void **state)
{
	struct made made = {.name = "dateline.tif", .srs = "EPSG:4326", .width = 60, .height = 40, .west = 179.97, .north = -16.5,
			    .dx = 0.001, .dy = 0.001, .type = GDT_Float32, .height_of = by_degree};
	struct dem *dem = make_and_open(&made);
	int64_t holes = 0, posts = 0;
	for (int64_t y = 3; y < dem_info(dem)->height - 3; y++)
		for (int64_t x = 3; x < dem_info(dem)->width - 3; x++, posts++)
			holes += isnan(height_at(dem, x, y));
	assert_true(posts > 1000 && holes == 0);
	dem_close(dem);
}

/* Reads all posts with so many threads, and measures them as one tile. The caller frees them. */
static double *read_all(const struct dem_params *params, int64_t jobs, int64_t *posts, struct misfit *misfit)
{
	struct dem_params with = *params;
	with.jobs = jobs;
	struct dem *dem = open_with(&with);
	const struct dem_info *info = dem_info(dem);
	const struct extent extent = {info->width, info->height, info->spacing, 2048};
	double *heights = mem_alloc((size_t)(info->width * info->height), sizeof *heights);
	int32_t *codes = mem_alloc((size_t)2049 * 2049, sizeof *codes);
	*posts = info->width * info->height;
	assert_int_equal(dem_read(dem, (struct post_rect){0, 0, info->width, info->height}, heights), STATUS_OK);
	for (int64_t i = 0; i < (int64_t)2049 * 2049; i++)
		codes[i] = HEIGHT_CODE_NODATA;
	for (int64_t y = 0; y < info->height; y++)
		assert_int_equal(height_code_row(heights + y * info->width, info->width, 0.001, codes + y * 2049), info->width);
	*misfit = (struct misfit){0};
	assert_int_equal(dem_misfit(dem, &extent, &(struct dem_tile){.codes = codes}, 0.001, misfit), STATUS_OK);
	mem_free(codes);
	dem_close(dem);
	return heights;
}

static void threads_do_not_show_in_heights(void **state)
{
	struct view views[2] = {metres(10), degrees()};
	const char *sources[2];
	views[1].more = 3;
	for (int i = 0; i < 2; i++) {
		make_view(&views[i]);
		sources[i] = in_folder(views[i].made.name);
	}
	struct dem_params params = params_of(sources, 2);
	params.spacing = 0.6; /* three columns of blocks */
	int64_t posts;
	struct misfit misfit;
	double *alone = read_all(&params, 0, &posts, &misfit);
	assert_true(posts > 1000000 && misfit.posts > 500 && misfit.squares > 0);
	for (int64_t jobs = 2; jobs <= 12; jobs += 5) {
		struct misfit other;
		double *heights = read_all(&params, jobs, &posts, &other);
		assert_memory_equal(heights, alone, (size_t)posts * sizeof *heights);
		assert_memory_equal(&other, &misfit, sizeof misfit);
		mem_free(heights);
	}
	mem_free(alone);
	assert_int_equal(thread_running(), 0);
}

/* Whichever thread meets it. */
static void a_broken_source_is_named_by_any_thread(void **state)
{
	struct view whole = metres(10), broken = metres(10);
	whole.made.width = broken.made.width = 700;
	broken.made.name = "broken.tif";
	broken.made.west += 7003;
	make_view(&whole);
	make_view(&broken);
	assert_int_equal(truncate(in_folder("broken.tif"), 20000), 0);
	const char *sources[] = {in_folder("metres.tif"), in_folder("broken.tif")};
	for (int64_t jobs = 0; jobs <= 4; jobs += 2) {
		struct dem_params params = params_of(sources, 2);
		params.jobs = jobs;
		params.spacing = 4;
		struct dem *dem = open_with(&params);
		double *row = mem_alloc((size_t)dem_info(dem)->width, sizeof *row);
		enum status status = STATUS_OK;
		for (int64_t y = 0; y < dem_info(dem)->height && status == STATUS_OK; y++)
			status = read_rows(dem, y, 1, row);
		assert_int_equal(status, STATUS_INPUT);
		assert_non_null(strstr(failure_message(), "broken.tif: reading it failed at row"));
		mem_free(row);
		dem_close(dem);
	}
}

static void fail_each(const struct dem_params *params)
{
	(void)mem_fail_nth(0, 0);
	struct dem *dem = open_with(params);
	double row[64];
	assert_int_equal(read_rows(dem, 0, 1, row), STATUS_OK);
	dem_close(dem);
	uint64_t count = mem_fail_nth(0, 0);
	assert_true(count > 20);
	for (uint64_t nth = 1; nth <= count; nth++) {
		dem = NULL;
		(void)mem_fail_nth(nth, 1);
		enum status status = dem_open(params, &dem);
		if (status == STATUS_OK)
			status = read_rows(dem, 0, 1, row);
		(void)mem_fail_nth(0, 0);
		assert_true(status != STATUS_OK);
		dem_close(dem);
	}
}

static void every_failing_allocation_of_mixed_sources_is_told(void **state)
{
	struct view a = metres(10), b = degrees();
	make_view(&a);
	make_view(&b);
	const char *sources[] = {in_folder("metres.tif"), in_folder("degrees.tif")};
	struct dem_params params = params_of(sources, 2);
	params.jobs = 2;
	params.has_window = true;
	params.window_srs = "EPSG:4326";
	memcpy(params.window, (double[]){15.0005, 45.1517, 15.0018, 45.1529}, sizeof params.window);
	fail_each(&params);
	params.s_vertical = "egm96";
	params.t_vertical = "ellipsoid";
	struct dem *dem;
	if (dem_open(&params, &dem) != STATUS_OK) { /* PROJ may lack the grid */
		assert_non_null(strstr(failure_message(), "egm96_15"));
		return;
	}
	dem_close(dem);
	fail_each(&params);
}

TEST_PROGRAM(mixed)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(three_systems_and_units_become_one_plane),
		cmocka_unit_test(of_two_systems_the_first_named_wins),
		cmocka_unit_test(an_edge_is_not_drawn_out_over_another_source),
		cmocka_unit_test(a_window_is_cut_in_any_system),
		cmocka_unit_test(source_keeps_the_posts_of_any_metric_system),
		cmocka_unit_test(wkt_may_begin_with_a_new_line),
		cmocka_unit_test(a_source_across_the_date_line_has_no_gap),
		cmocka_unit_test(threads_do_not_show_in_heights),
		cmocka_unit_test(a_broken_source_is_named_by_any_thread),
		cmocka_unit_test(every_failing_allocation_of_mixed_sources_is_told),
	};
	return cmocka_run_group_tests_name("mixed", tests, folder_make, folder_remove);
}
