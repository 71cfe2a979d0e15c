/*
 * Law 6 through the page cache and the run's adaptor (src/resident/pages.c), without GL: whatever fails,
 * it is told and goes on being told, no page that the store has not is let go, and the store holds
 * exactly what the ground was at the end of the step of its last epoch.
 *
 * Staging and slots of the GPU are this file's own: it has the functions of gpu that the adaptor calls, so that
 * the linker takes no others. The threads' calls come in any order; some Ns of each kind are tried. All of it is tried with pages in
 * host memory, too.
 */
#include "sweep.h"

#include "resident/resident.h"
#include "world/record.h"
#include "../support/program.h"
#include "../support/skip.h"

#define MOST 25
#define LEVEL -1
enum { SLOTS = 6, STEPS = 24, RADIUS = 5 };

/* --- staging, which is its bytes and no more, and slots in memory --- */

enum status gpu_staging_create(struct gpu *gpu, size_t bytes, struct gpu_staging **out)
{
	*out = mem_alloc(1, bytes);
	return *out != NULL ? STATUS_OK : fail_memory("staging");
}

void gpu_staging_destroy(struct gpu_staging *staging)
{
	mem_free(staging);
}

void *gpu_staging_bytes(struct gpu_staging *staging)
{
	return staging;
}

bool gpu_staging_idle(struct gpu_staging *staging)
{
	return true;
}

enum status gpu_check(struct gpu *gpu, const char *what)
{
	return STATUS_OK;
}

struct gpu_slots {
	struct {
		bool deformed;
		int32_t planes[PLANES][POSTS]; /* of texels of any size */
		uint8_t classes[POSTS];
	} slots[SLOTS];
};

unsigned gpu_slots_planes(const struct gpu_slots *slots)
{
	return (1u << PLANES) - 1;
}

enum status gpu_slots_upload_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging, size_t posts)
{
	return STATUS_OK;
}

enum status gpu_slots_subdivide_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t patch, int shift, uint32_t sub_x, uint32_t sub_y)
{
	return STATUS_OK;
}

enum status gpu_slots_subdivide_relief(struct gpu_slots *slots, uint32_t slot,
				       struct gpu_staging *staging, size_t patch, uint32_t sub_x,
				       uint32_t sub_y, struct tile tile,
				       const struct relief *relief)
{
	return STATUS_OK;
}

enum status gpu_slots_deform(struct gpu_slots *slots, uint32_t slot)
{
	if (!slots->slots[slot].deformed)
		memset(slots->slots[slot].planes, 0, sizeof slots->slots[slot].planes);
	slots->slots[slot].deformed = true;
	return STATUS_OK;
}

void gpu_slots_undeform(struct gpu_slots *slots, uint32_t slot)
{
	slots->slots[slot].deformed = false;
}

enum status gpu_slots_upload_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				    const size_t places[PLANES])
{
	slots->slots[slot].deformed = true;
	for (int plane = 0; plane < PLANES; plane++) {
		size_t bytes = POSTS * plane_bytes((enum plane)plane);
		memset(slots->slots[slot].planes[plane], 0, bytes);
		if (places[plane] != GPU_NO_PLANE)
			memcpy(slots->slots[slot].planes[plane], (char *)staging + places[plane], bytes);
	}
	return STATUS_OK;
}

enum status gpu_slots_read_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  const size_t places[PLANES])
{
	for (int plane = 0; plane < PLANES; plane++)
		memcpy((char *)staging + places[plane], slots->slots[slot].planes[plane], POSTS * plane_bytes((enum plane)plane));
	return STATUS_OK;
}

static uint8_t class_of(struct tile tile, int post)
{
	return (uint8_t)(mix(tile.x, tile.y, (uint32_t)post) & 15);
}

enum status gpu_slots_upload_classes(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging, size_t classes)
{
	memcpy(slots->slots[slot].classes, (char *)staging + classes, POSTS);
	return STATUS_OK;
}

enum status gpu_slots_decimate(struct gpu_slots *slots, uint32_t fine, struct gpu_rect rect, int steps,
			       uint32_t coarse, uint32_t to_x, uint32_t to_y)
{
	fail_msg("only the working level is resident here");
	return STATUS_FAILED;
}

const struct gpu_slot *gpu_slots_get(const struct gpu_slots *slots, uint32_t slot)
{
	fail_msg("nobody asks for the newest values here");
	return NULL;
}

void gpu_texture_read(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, void *data)
{
	fail_msg("nobody asks for the newest values here");
}

/* --- a drive of steps, each around the corner of four tiles --- */

struct rig {
	struct store *store;
	struct gpu_slots slots;
	struct host_slots *host; /* NULL: pages are in slots of the GPU */
	struct pages *pages;
	struct page_cache *cache;
	FILE *log;
	struct field field; /* the ground as it is now */
	int steps;          /* that field has */
};

static void corner_of(int step, uint32_t *x, uint32_t *y)
{
	*x = 1 + (uint32_t)step * 2 % 9;
	*y = 1 + (uint32_t)step % 6;
}

static void dig_step(struct field *field, int step)
{
	uint32_t x, y;
	corner_of(step, &x, &y);
	field_dig(field, 16 * x, 16 * y, RADIUS, (uint32_t)step);
}

static enum status nothing_before(void *user, struct tile tile, uint32_t slot)
{
	return STATUS_OK;
}

static const struct scene scene = {.hash = "abc"};

/* What the steps up to this one compacted; less at times, where soil springs back. */
static int64_t compacted_by(int64_t step)
{
	return step * 1000000007 - (step % 3) * INT64_C(5000000000);
}

#define COMPACTED_BEFORE (-99)

static enum status fill_tally(void *user, uint8_t *bytes)
{
	const struct rig *rig = user;
	int64_t tally[5] = {compacted_by(rig->steps), 0, 0, rig->steps, 3 * rig->steps};
	_Static_assert(sizeof tally == PAGES_TALLY_BYTES, "the tally");
	memcpy(bytes, tally, sizeof tally);
	return STATUS_OK;
}

static enum status take_tally(void *user, struct gpu_staging *staging)
{
	return fill_tally(user, (uint8_t *)staging);
}

static enum status give_classes(void *user, unsigned loader, struct tile tile, uint8_t *classes)
{
	expect(loader < 2 && tile.level == LEVEL);
	for (int i = 0; i < POSTS; i++)
		classes[i] = class_of(tile, i);
	return STATUS_OK;
}

static enum status rig_open(struct rig *rig, const char *path, bool host)
{
	struct store_options options = {.mode = STORE_WRITE};
	enum status status = store_open(path, &options, &rig->store);
	if (status == STATUS_OK)
		status = store_set_working_level(rig->store, LEVEL);
	if (status != STATUS_OK)
		return status;
	if (host)
		status = resident_host_create(extent.cells, SLOTS, gpu_slots_planes(&rig->slots), &rig->host);
	if (status != STATUS_OK)
		return status;
	struct pages_params params = {
		.store = rig->store,
		.slots = host ? NULL : &rig->slots,
		.host = rig->host,
		.planes = gpu_slots_planes(&rig->slots),
		.level = LEVEL,
		.count = SLOTS,
		.loaders = 2,
		.step_pages = 4,
		.record = world_record_pages(&scene),
		.commit_log = rig->log,
		.before.compacted = COMPACTED_BEFORE,
		.before_read_back = nothing_before,
		.snapshot = take_tally,
		.tally = fill_tally,
		.classes = give_classes,
		.user = rig,
	};
	status = resident_pages_create(&params, &rig->pages);
	if (status == STATUS_OK)
		rig->cache = resident_pages_cache(rig->pages);
	return status;
}

static void *plane_of(struct rig *rig, uint32_t slot, enum plane plane)
{
	return rig->host != NULL ? resident_host_plane(rig->host, slot, plane) : rig->slots.slots[slot].planes[plane];
}

static const uint8_t *classes_of(const struct rig *rig, uint32_t slot)
{
	struct host_slot held;
	if (rig->host == NULL)
		return rig->slots.slots[slot].classes;
	resident_host_get(rig->host, slot, &held);
	return held.classes;
}

static enum status make_ready(struct rig *rig, uint32_t slot)
{
	return rig->host != NULL ? resident_host_write(rig->host, slot, ~0u) : gpu_slots_deform(&rig->slots, slot);
}

/* What the tile in the slot holds is what the ground was before the step. */
static void step_tile(struct rig *rig, struct tile tile, uint32_t slot, const struct field *before)
{
	for (int i = 0; i < POSTS; i++)
		expect(classes_of(rig, slot)[i] == class_of(tile, i));
	for (int plane = 0; plane < PLANES; plane++) {
		int32_t texels[POSTS];
		field_tile_plane(before, tile, (enum plane)plane, texels);
		expect(memcmp(plane_of(rig, slot, (enum plane)plane), texels, POSTS * plane_bytes((enum plane)plane)) == 0);
		field_tile_plane(&rig->field, tile, (enum plane)plane, plane_of(rig, slot, (enum plane)plane));
	}
	page_cache_dirty(rig->cache, tile_key(tile));
	page_cache_unpin(rig->cache, tile_key(tile));
}

static enum status one_step(struct rig *rig, int step, struct record *record)
{
	uint32_t x, y, slots[4];
	uint64_t keys[4];
	corner_of(step, &x, &y);
	for (uint32_t i = 0; i < 4; i++)
		keys[i] = tile_key((struct tile){LEVEL, x - 1 + i % 2, y - 1 + i / 2});
	enum status status = page_cache_pin_all(rig->cache, keys, 4, slots);
	if (status != STATUS_OK)
		return status;
	for (uint32_t i = 0; i < 4 && status == STATUS_OK; i++)
		status = make_ready(rig, slots[i]);
	for (uint32_t i = 0; i < 4 && status != STATUS_OK; i++)
		page_cache_unpin(rig->cache, keys[i]);
	if (status != STATUS_OK)
		return status;
	struct field before = field_make(LEVEL);
	for (int plane = 0; plane < PLANES; plane++)
		memcpy(before.planes[plane], rig->field.planes[plane],
		       (size_t)(before.width * before.height) * plane_bytes((enum plane)plane));
	dig_step(&rig->field, step);
	rig->steps = step;
	for (uint32_t i = 0; i < 4; i++)
		step_tile(rig, tile_from_key(keys[i]), slots[i], &before);
	field_free(&before);
	record->step = step;
	return page_cache_end_step(rig->cache, record);
}

/* --- what the store has, and what it has not --- */

/* Epochs that were acknowledged. */
static int acknowledged(const struct rig *rig)
{
	int lines = 0;
	rewind(rig->log);
	for (int c; (c = getc(rig->log)) != EOF;)
		lines += c == '\n';
	return lines;
}

struct held {
	const struct rig *rig;
	bool has[7][10]; /* y, x: the cache has what the ground is now */
};

static void hold(struct held *held, uint64_t key)
{
	struct tile tile = tile_from_key(key);
	held->has[tile.y][tile.x] = true;
}

static void hold_queued(void *user, const struct page_image *image)
{
	hold(user, image->key);
}

static void hold_resident(void *user, uint64_t key, uint32_t slot, bool dirty)
{
	struct held *held = user;
	int32_t offset[POSTS];
	uint8_t dirt[POSTS];
	if (!dirty)
		return;
	field_tile(&held->rig->field, tile_from_key(key), offset, dirt);
	struct host_slot in_host;
	if (held->rig->host != NULL)
		resident_host_get(held->rig->host, slot, &in_host);
	expect(memcmp(held->rig->host != NULL ? in_host.planes[PLANE_OFFSET] : held->rig->slots.slots[slot].planes[PLANE_OFFSET], offset,
		      sizeof offset) == 0);
	hold(held, key);
}

/* Every plane of the tile. */
static bool stored_is(struct store_reader *reader, const struct field *field, struct tile tile)
{
	int32_t stored[PLANES][POSTS], texels[POSTS];
	void *planes[PLANES];
	unsigned present;
	bool same = true;
	for (int plane = 0; plane < PLANES; plane++)
		planes[plane] = stored[plane];
	expect(store_read_deformed(reader, tile, (1u << PLANES) - 1, planes, &present) == STATUS_OK);
	for (int plane = 0; plane < PLANES; plane++) {
		field_tile_plane(field, tile, (enum plane)plane, texels);
		same &= memcmp(stored[plane], texels, POSTS * plane_bytes((enum plane)plane)) == 0;
	}
	return same;
}

/* A page that differs from the store is dirty in its slot or in the queue. */
static void expect_pages_kept(struct rig *rig)
{
	struct held held = {.rig = rig};
	struct store_reader *reader;
	page_cache_each_queued(rig->cache, hold_queued, &held);
	page_cache_each_resident(rig->cache, hold_resident, &held);
	expect(store_reader_create(rig->store, &reader) == STATUS_OK);
	for (uint32_t y = 0; y < extent_tiles_y(&extent, LEVEL); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&extent, LEVEL); x++) {
			struct tile tile = {LEVEL, x, y};
			expect(held.has[y][x] || stored_is(reader, &rig->field, tile));
		}
	store_reader_destroy(reader);
}

/* The ground of the step that the last epoch says. */
static void look(const char *path, int least, int most)
{
	struct store *store;
	struct store_reader *reader;
	struct store_check check;
	struct store_numbers numbers;
	expect(store_open(path, &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK);
	expect(check.problems == 0);
	expect(store_count(store, &numbers) == STATUS_OK);
	expect(numbers.commits >= least && numbers.commits <= most);
	struct field field = field_make(LEVEL);
	for (int step = 1; numbers.commits > 0 && step <= numbers.last_run.step; step++)
		dig_step(&field, step);
	expect(store_reader_create(store, &reader) == STATUS_OK);
	for (uint32_t y = 0; y < extent_tiles_y(&extent, LEVEL); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&extent, LEVEL); x++)
			expect(stored_is(reader, &field, (struct tile){LEVEL, x, y}));
	store_reader_destroy(reader);
	/* What was compacted belongs to the same step, and so does the record's share of it. */
	int64_t compacted = numbers.commits > 0 ? compacted_by(numbers.last_run.step) : 0;
	expect(numbers.compacted == compacted && check.compacted == compacted);
	if (numbers.commits > 0) {
		struct record *record = calloc(1, world_record_bytes(0));
		assert_non_null(record);
		expect(world_record_parse(&numbers.last_run, "trial", &scene, record) == STATUS_OK);
		expect(record->sums.compacted == compacted + COMPACTED_BEFORE);
		expect(record->sums.sunk == numbers.last_run.step && record->sums.slid == 3 * numbers.last_run.step);
		free(record);
	}
	field_free(&field);
	store_close(store);
}

/* --- trials --- */

static enum status drive(struct rig *rig)
{
	struct record *record = calloc(1, world_record_bytes(0));
	assert_non_null(record);
	enum status status = STATUS_OK;
	for (int step = 1; step <= STEPS && status == STATUS_OK; step++)
		status = one_step(rig, step, record);
	if (status == STATUS_OK)
		status = page_cache_flush(rig->cache, record);
	free(record);
	return status;
}

/* Only the writer writes: what it could not commit is not forgotten when the next thing is asked. */
static void expect_sticky(struct rig *rig)
{
	struct record *record = calloc(1, world_record_bytes(0));
	uint32_t slot;
	assert_non_null(record);
	expect(told(page_cache_end_step(rig->cache, record)));
	expect(told(page_cache_flush(rig->cache, record)));
	expect(told(page_cache_pin(rig->cache, tile_key((struct tile){LEVEL, 0, 0}), &slot)));
	free(record);
}

static uint64_t trial_with(const struct fault *fault, FILE *log, bool log_fails, bool host)
{
	static struct rig rig;
	const char *path = in_folder("trial.furrow");
	unlink(path);
	copy_file(in_folder("fresh"), path);
	rig = (struct rig){.log = log, .field = field_make(LEVEL)};
	fault_arm_for(fault);
	enum status status = rig_open(&rig, path, host);
	if (status == STATUS_OK)
		status = drive(&rig);
	expect(status == STATUS_OK || told(status));
	if (status != STATUS_OK && rig.cache != NULL &&
	    (log_fails || (fault->kind >= FAULT_WRITE && fault->kind <= FAULT_TORN_WRITE)))
		expect_sticky(&rig);
	uint64_t calls = fault_disarm();
	if (rig.cache != NULL)
		expect_pages_kept(&rig);
	resident_pages_destroy(rig.pages);
	resident_host_destroy(rig.host);
	store_close(rig.store);
	expect(calls >= fault->nth || log_fails || (status == STATUS_OK && rig.steps == STEPS));
	/* The last may have been committed and not acknowledged. */
	int least = log_fails ? 0 : acknowledged(&rig);
	look(path, least, least + (status != STATUS_OK));
	expect(status != STATUS_OK || least >= 3);
	/* A writer that ends well tidies up after one that did not. */
	store_close(open_store(path, STORE_WRITE));
	expect(files_of("trial.furrow") == 1);
	field_free(&rig.field);
	return calls;
}

static uint64_t trial(const void *user, const struct fault *fault)
{
	FILE *log = tmpfile();
	assert_non_null(log);
	uint64_t calls = trial_with(fault, log, false, user != NULL);
	fclose(log);
	return calls;
}

/* host NULL: pages are in slots of the GPU. */
static void sweep_all(const char *host)
{
	uint64_t ran = 0;
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep(trial, host, (enum fault_kind)kind, MOST);
	assert_true(ran > 100 / SWEEP_PART);
}

static void a_failed_write_back_is_told_and_its_pages_are_kept(void **state)
{
	sweep_all(NULL);
}

static void so_are_pages_in_host_memory(void **state)
{
	sweep_all("host memory");
}

static void an_epoch_that_cannot_be_acknowledged_is_told(void **state)
{
	FILE *log = fopen("/dev/full", "a+");
	if (log == NULL)
		skip_since(SKIP_ELSEWHERE "no /dev/full");
	trial_with(&(struct fault){FAULT_NONE, UINT64_MAX, false}, log, true, false);
	rewind(log);
	trial_with(&(struct fault){FAULT_NONE, UINT64_MAX, false}, log, true, true);
	fclose(log);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	make_store(in_folder("fresh"));
	return 0;
}

TEST_PROGRAM(pages)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_failed_write_back_is_told_and_its_pages_are_kept),
		cmocka_unit_test(so_are_pages_in_host_memory),
		cmocka_unit_test(an_epoch_that_cannot_be_acknowledged_is_told),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
