/* Two overlays of one store that were driven apart, and what their merge is. */
#ifndef FURROW_TEST_FAULT_SIDES_H
#define FURROW_TEST_FAULT_SIDES_H

#include "epochs.h"

static char base[256], sides[2][256], lost[256]; /* lost: side 0, whose base is gone */
static uint64_t merged_hash, side_hash, fresh_hash, driven_hash; /* driven: that of the base */

static void drive_side(const char *path, int number)
{
	struct store *store;
	struct store_commit_result result;
	struct field field = field_make(LEVEL);
	for (int i = 1; i <= 2; i++)
		dig(&field, i);
	assert_ok(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store));
	assert_ok(store_set_working_level(store, LEVEL));
	for (int i = 1; i <= 2 && number == 0; i++)
		assert_ok(field_commit(&field, field_all(&field), store, i, &result));
	if (number > 0)
		assert_ok(field_commit(&field, dig(&field, number), store, number, &result));
	store_close(store);
	field_free(&field);
}

static uint64_t content_of(const char *path)
{
	struct store *store = open_store(path, STORE_READ);
	uint64_t hash = content(store);
	verified(store);
	store_close(store);
	return hash;
}

/* Makes them in the folder of this group of tests, which it makes, too. */
static int make_sides(void **state)
{
	struct store_conflicts conflicts;
	if (folder_make(state) != 0)
		return -1;
	snprintf(base, sizeof base, "%s/base.furrow", folder);
	make_store(base);
	copy_file(base, in_folder("fresh"));
	fresh_hash = content_of(base);
	drive_side(base, 0);
	for (int i = 0; i < 2; i++) {
		snprintf(sides[i], sizeof sides[i], "%s/side%d.furrow", folder, i);
		assert_ok(store_create_overlay(sides[i], base));
		drive_side(sides[i], 3 + 2 * i);
	}
	side_hash = content_of(sides[0]);
	driven_hash = content_of(base);
	assert_ok(store_merge(sides[0], sides[1], in_folder("reference.furrow"), &conflicts));
	merged_hash = content_of(in_folder("reference.furrow"));
	assert_true(merged_hash != side_hash && side_hash != fresh_hash && merged_hash != fresh_hash);
	snprintf(lost, sizeof lost, "%s/lost.furrow", folder);
	copy_file(sides[0], lost);
	raw_sql(lost, "UPDATE meta SET value = 'gone.furrow' WHERE key = 'base_path'");
	return 0;
}

/* Opens what is there as its next writer would. */
static uint64_t found_in(const char *path)
{
	struct store *store;
	struct store_check check;
	uint64_t hash;
	expect(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK && check.problems == 0);
	expect(store_content_hash(store, &hash) == STATUS_OK);
	store_close(store);
	return hash;
}

#endif
