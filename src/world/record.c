#include "world/record.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "bearing/bearing.h"

#define VERSION 3
#define SUM_MOST (INT64_MAX / 4) /* so that sums and differences are still numbers */

size_t world_record_bytes(size_t objects)
{
	return sizeof(struct record) + objects * sizeof(struct record_object);
}

size_t world_record_bytes_with(size_t objects, size_t attached)
{
	return world_record_bytes(objects) + attached * sizeof(double);
}

size_t world_record_bytes_of(const struct record *record, size_t objects)
{
	return world_record_bytes_with(objects, record->attached_count) + record->carried_count * sizeof(int64_t) + record->thrown.room * sizeof(struct bearing_grain);
}

int64_t *world_record_carried(struct record *record, size_t objects)
{
	return (int64_t *)(void *)(world_record_attached(record, objects) + record->attached_count);
}

struct bearing_grain *world_record_grains(struct record *record, size_t objects)
{
	return (struct bearing_grain *)(void *)(world_record_carried(record, objects) + record->carried_count);
}

/* Returns how many of the numbers of soil aboard are of the bodies of vehicles. They follow those of the objects. */
static size_t carried_by_vehicles(const struct record *record, size_t objects)
{
	size_t count = record->carried_count;
	for (size_t i = 0; i < objects; i++)
		count -= record->objects[i].carried;
	return count;
}

double *world_record_attached(struct record *record, size_t objects)
{
	return (double *)(void *)&record->objects[objects];
}

/* --- writing; each returns false when out of memory --- */

static bool put_whole(cJSON *object, const char *name, int64_t value)
{
	char text[32];
	snprintf(text, sizeof text, "%lld", (long long)value);
	return cJSON_AddStringToObject(object, name, text) != NULL;
}

static bool put_real(cJSON *object, const char *name, double value)
{
	char text[40];
	snprintf(text, sizeof text, "%a", value);
	return cJSON_AddStringToObject(object, name, text) != NULL;
}

static bool put_force(cJSON *object, const struct world_force *force)
{
	static const char *const names[] = {"fx", "fy", "fz", "tx", "ty", "tz"};
	cJSON *to = cJSON_AddObjectToObject(object, "force");
	bool whole = to != NULL && put_real(to, "sinkage", force->sinkage) && put_real(to, "area", force->area) &&
		     put_whole(to, "z", force->z) && put_whole(to, "state", force->state) && put_real(to, "residual", force->residual) &&
		     put_real(to, "pull", force->pull);
	for (int i = 0; i < 6 && whole; i++)
		whole = put_real(to, names[i], i < 3 ? force->force[i] : force->moment[i - 3]);
	return whole && (!(fabs(force->work) > 0) || put_real(to, "work", force->work)); /* only bodies that carry soil have any */
}

/* "number;" for each. Without any motion the record is as it was before there was a trend. */
static bool put_trend(cJSON *object, const struct soil_trend *trend)
{
	double numbers[SOIL_TREND_NUMBERS];
	char text[SOIL_TREND_NUMBERS * 32 + 1], *at = text;
	bool any = false;
	soil_trend_save(trend, numbers);
	for (int i = 0; i < SOIL_TREND_NUMBERS; i++)
		any |= fabs(numbers[i]) > 0;
	if (!any)
		return true;
	for (int i = 0; i < SOIL_TREND_NUMBERS; i++)
		at += snprintf(at, 32, "%a;", numbers[i]);
	return cJSON_AddStringToObject(object, "trend", text) != NULL;
}

/* "index,number;" for each that is not 0. Without soil aboard the record is as it was before there was any. */
static bool put_carried(cJSON *object, const char *name, const int64_t *numbers, size_t count)
{
	const size_t most = 2 * 20 + 3;
	size_t has = 0;
	for (size_t i = 0; i < count; i++)
		has += numbers[i] != 0;
	if (has == 0)
		return true;
	char *text = mem_alloc(has * most + 1, 1), *at = text;
	if (text == NULL)
		return false;
	for (size_t i = 0; i < count; i++)
		if (numbers[i] != 0)
			at += snprintf(at, most, "%zu,%lld;", i, (long long)numbers[i]);
	const bool whole = cJSON_AddStringToObject(object, name, text) != NULL;
	mem_free(text);
	return whole;
}

static bool put_object(cJSON *objects, const struct record_object *from, const char *name, const int64_t *carried)
{
	cJSON *object = cJSON_CreateObject();
	if (!cJSON_AddItemToArray(objects, object)) {
		cJSON_Delete(object);
		return false;
	}
	return cJSON_AddStringToObject(object, "name", name) != NULL && put_whole(object, "next", from->next) &&
	       cJSON_AddBoolToObject(object, "in_contact", from->has_last) != NULL &&
	       put_whole(object, "x", from->last.x) && put_whole(object, "y", from->last.y) &&
	       put_whole(object, "z", from->last.z) && put_real(object, "yaw", from->last.yaw) &&
	       put_real(object, "pitch", from->last.pitch) && put_real(object, "roll", from->last.roll) &&
	       put_real(object, "turn", from->last.turn) && put_force(object, &from->force) &&
	       put_real(object, "distance", from->distance) && put_real(object, "sinkage", from->sinkage) &&
	       put_whole(object, "skipped", from->skipped) && put_trend(object, &from->trend) && put_carried(object, "carried", carried, from->carried);
}

/* "x,y;" for each block. */
static bool put_active(cJSON *root, const struct record *record)
{
	const size_t most = 2 * 20 + 3;
	char *text = mem_alloc(record->active_count * most + 1, 1), *at = text;
	if (text == NULL)
		return false;
	*at = '\0';
	for (size_t i = 0; i < record->active_count; i++)
		at += snprintf(at, most, "%lld,%lld;", (long long)record->active[i].x, (long long)record->active[i].y);
	bool whole = cJSON_AddStringToObject(root, "awake", text) != NULL;
	mem_free(text);
	return whole;
}

/* "number;" for each attached number. Without any the record is as it was before there were any. */
static bool put_attached(cJSON *root, const struct record *record, size_t objects)
{
	const size_t most = 32, count = record->attached_count;
	const double *numbers = world_record_attached((struct record *)record, objects);
	if (count == 0)
		return true;
	char *text = mem_alloc(count * most + 1, 1), *at = text;
	if (text == NULL)
		return false;
	for (size_t i = 0; i < count; i++)
		at += snprintf(at, most, "%a;", numbers[i]);
	bool whole = cJSON_AddStringToObject(root, "attached", text) != NULL;
	mem_free(text);
	return whole;
}

/* Orders grains by all of their numbers, so that it does not show in which order they left, nor on which rank they fly. */
static int by_numbers(const void *a, const void *b)
{
	int64_t first[GRAIN_NUMBERS], second[GRAIN_NUMBERS];
	bearing_grain_save(a, first);
	bearing_grain_save(b, second);
	for (int k = 0; k < GRAIN_NUMBERS; k++)
		if (first[k] != second[k])
			return first[k] < second[k] ? -1 : 1;
	return 0;
}

/* The sums, and "number,...;" for each grain in flight, sorted. Where nothing is thrown the record is as it was before there was that. */
static bool put_thrown(cJSON *root, const struct record *record, size_t objects)
{
	const size_t most = GRAIN_NUMBERS * 21 + 1;
	struct bearing_grain *grains;
	int64_t numbers[GRAIN_NUMBERS];
	char sums[SOIL_CLASSES * 21 + 1], *at = sums;
	if (record->thrown.room == 0)
		return true;
	for (int i = 0; i < SOIL_CLASSES; i++)
		at += snprintf(at, 22, "%lld;", (long long)record->thrown.thrown[i]);
	char *text = mem_alloc(record->thrown.count * most + 1, 1);
	grains = mem_alloc(record->thrown.count + 1, sizeof *grains);
	if (text == NULL || grains == NULL) {
		mem_free_all(text, grains);
		return false;
	}
	memcpy(grains, world_record_grains((struct record *)record, objects), record->thrown.count * sizeof *grains);
	qsort(grains, record->thrown.count, sizeof *grains, by_numbers);
	at = text;
	*at = '\0';
	for (size_t i = 0; i < record->thrown.count; i++) {
		bearing_grain_save(&grains[i], numbers);
		for (int k = 0; k < GRAIN_NUMBERS; k++)
			at += snprintf(at, 22, "%lld%c", (long long)numbers[k], k + 1 < GRAIN_NUMBERS ? ',' : ';');
	}
	mem_free(grains);
	const bool whole = cJSON_AddStringToObject(root, "thrown", sums) != NULL && put_whole(root, "landed", record->thrown.landed) &&
			   put_whole(root, "lost", record->thrown.lost) && cJSON_AddStringToObject(root, "grains", text) != NULL;
	mem_free(text);
	return whole;
}

/* The store's time: without marks that fade the record is as it was before there were any. store_age.c reads it. */
static bool put_marks(cJSON *root, const struct store_marks *marks)
{
	return !marks->any || (put_real(root, "since", marks->since) && (marks->heals <= 0 || put_real(root, "heals", marks->heals)) &&
			       (marks->rises <= 0 || (put_real(root, "rises", marks->rises) && put_real(root, "grows", marks->grows))));
}

char *world_record_print(const struct record *record, const struct scene *scene, const struct pages_sums *sums)
{
	cJSON *root = cJSON_CreateObject(), *objects;
	const int64_t *carried = world_record_carried((struct record *)record, scene->object_count);
	bool whole = cJSON_AddNumberToObject(root, "version", VERSION) != NULL &&
		     put_whole(root, "law", record->law) && put_whole(root, "level", record->level) &&
		     cJSON_AddBoolToObject(root, "ended", record->ended) != NULL &&
		     put_whole(root, "below", sums->below) && put_whole(root, "above", sums->above) &&
		     put_whole(root, "compacted", sums->compacted) && put_whole(root, "sunk", sums->sunk) &&
		     put_whole(root, "slid", sums->slid) && (sums->added == 0 || put_whole(root, "added", sums->added)) &&
		     (sums->carried == 0 || put_whole(root, "carried", sums->carried)) && (sums->in_flight == 0 || put_whole(root, "in_flight", sums->in_flight)) && put_marks(root, &record->marks) && put_active(root, record) && (objects = cJSON_AddArrayToObject(root, "objects")) != NULL;
	for (size_t i = 0; i < scene->object_count && whole; carried += record->objects[i].carried, i++)
		whole = put_object(objects, &record->objects[i], scene->objects[i].name, carried);
	whole = whole && put_carried(root, "aboard", carried, carried_by_vehicles(record, scene->object_count));
	whole = whole && put_attached(root, record, scene->object_count) && put_thrown(root, record, scene->object_count);
	char *printed = whole ? cJSON_PrintUnformatted(root) : NULL, *text = NULL;
	cJSON_Delete(root);
	if (printed != NULL)
		text = mem_strdup(printed);
	cJSON_free(printed);
	return text;
}

static void when(const void *from, int64_t *step, double *time)
{
	const struct record *record = from;
	*step = record->step;
	*time = record->time;
}

int64_t world_record_in_flight(const struct record *record, size_t objects)
{
	const struct bearing_grain *grains = world_record_grains((struct record *)record, objects);
	int64_t volume = 0;
	for (size_t i = 0; i < record->thrown.count; i++)
		volume += grains[i].volume;
	return volume;
}

static struct pages_soil soil(const void *scene, const void *from)
{
	const struct record *record = from;
	return (struct pages_soil){record->added, record->carried, world_record_in_flight(record, ((const struct scene *)scene)->object_count)};
}

static char *print(const void *scene, const void *record, const struct pages_sums *sums)
{
	return world_record_print(record, scene, sums);
}

struct pages_record world_record_pages(const struct scene *scene)
{
	return (struct pages_record){world_record_bytes(scene->object_count), scene->hash, scene, when, print, soil};
}

/* --- reading; each returns false if the value is missing or wrong --- */

static const char *get_text(const cJSON *object, const char *name)
{
	return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, name));
}

static bool get_whole(const cJSON *object, const char *name, int64_t low, int64_t *value)
{
	const char *text = get_text(object, name);
	char *end;
	if (text == NULL || strspn(text, "-0123456789") != strlen(text) || *text == '\0')
		return false;
	errno = 0;
	*value = strtoll(text, &end, 10);
	return *end == '\0' && errno == 0 && *value >= low;
}

static bool get_real(const cJSON *object, const char *name, double *value)
{
	const char *text = get_text(object, name);
	char *end;
	if (text == NULL || strspn(text, "+-.0123456789abcdefpx") != strlen(text) || *text == '\0')
		return false;
	*value = strtod(text, &end);
	return *end == '\0' && isfinite(*value);
}

static bool get_bool(const cJSON *object, const char *name, bool *value)
{
	const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, name);
	*value = cJSON_IsTrue(item);
	return cJSON_IsBool(item);
}

static bool get_force(const cJSON *object, struct world_force *force)
{
	static const char *const names[] = {"fx", "fy", "fz", "tx", "ty", "tz"};
	const cJSON *from = cJSON_GetObjectItemCaseSensitive(object, "force");
	int64_t state;
	bool whole = get_real(from, "sinkage", &force->sinkage) && get_real(from, "area", &force->area) &&
		     get_whole(from, "z", INT64_MIN, &force->z) && get_whole(from, "state", 0, &state) && state < DEFORM_STATES &&
		     get_real(from, "residual", &force->residual);
	force->pull = 0; /* records of earlier versions have none */
	if (cJSON_HasObjectItem(from, "pull"))
		whole = whole && get_real(from, "pull", &force->pull);
	force->work = 0;
	if (cJSON_HasObjectItem(from, "work"))
		whole = whole && get_real(from, "work", &force->work);
	force->state = whole ? (enum deform_state)state : DEFORM_AIR;
	for (int i = 0; i < 6 && whole; i++)
		whole = get_real(from, names[i], i < 3 ? &force->force[i] : &force->moment[i - 3]);
	return whole;
}

/* Reads numbers, each with ';' after it. */
static bool get_numbers(const char *at, size_t count, double *numbers)
{
	if (at == NULL || strspn(at, "+-.0123456789abcdefpx;") != strlen(at))
		return false;
	for (size_t i = 0; i < count; i++) {
		char *end;
		numbers[i] = strtod(at, &end);
		if (end == at || *end != ';' || !isfinite(numbers[i]))
			return false;
		at = end + 1;
	}
	return *at == '\0';
}

/* Records of earlier versions have none. */
static bool get_trend(const cJSON *object, struct soil_trend *trend)
{
	double numbers[SOIL_TREND_NUMBERS] = {0};
	if (cJSON_HasObjectItem(object, "trend") && !get_numbers(get_text(object, "trend"), SOIL_TREND_NUMBERS, numbers))
		return false;
	soil_trend_load(numbers, trend);
	return true;
}

/* Reads a number of a block's place, and the character `behind` after it. */
static bool get_place(const char **at, char behind, int64_t *value)
{
	char *end;
	if (**at < '0' || **at > '9')
		return false;
	errno = 0;
	*value = strtoll(*at, &end, 10);
	*at = end + 1;
	return errno == 0 && *end == behind;
}

/* Reads what put_carried wrote. */
static bool get_carried(const cJSON *object, const char *name, int64_t *numbers, size_t count)
{
	const char *at = get_text(object, name);
	memset(numbers, 0, count * sizeof *numbers);
	if (!cJSON_HasObjectItem(object, name))
		return true;
	while (at != NULL && *at != '\0') {
		int64_t index, value;
		if (!get_place(&at, ',', &index) || !get_place(&at, ';', &value) || (uint64_t)index >= count)
			return false;
		numbers[index] = value;
	}
	return at != NULL;
}

static bool get_object(const cJSON *object, const char *name, struct record_object *to)
{
	const char *named = get_text(object, "name");
	return named != NULL && strcmp(named, name) == 0 && get_whole(object, "next", 0, &to->next) &&
	       get_bool(object, "in_contact", &to->has_last) && get_whole(object, "x", INT64_MIN, &to->last.x) &&
	       get_whole(object, "y", INT64_MIN, &to->last.y) && get_whole(object, "z", INT64_MIN, &to->last.z) &&
	       get_real(object, "yaw", &to->last.yaw) && get_real(object, "pitch", &to->last.pitch) &&
	       get_real(object, "roll", &to->last.roll) &&
	       get_real(object, "turn", &to->last.turn) && get_force(object, &to->force) && get_real(object, "distance", &to->distance) &&
	       to->distance >= 0 && get_real(object, "sinkage", &to->sinkage) &&
	       get_whole(object, "skipped", 0, &to->skipped) && to->skipped <= to->next && get_trend(object, &to->trend);
}

static bool get_active(const cJSON *root, struct record *record)
{
	const char *at = get_text(root, "awake");
	record->active_count = 0;
	if (at == NULL)
		return false;
	while (*at != '\0') {
		struct soil_block *block = &record->active[record->active_count];
		if (record->active_count == DEFORM_BLOCKS_MAX || !get_place(&at, ',', &block->x) || !get_place(&at, ';', &block->y))
			return false;
		record->active_count++;
	}
	return true;
}

static bool get_aboard(const cJSON *root, size_t objects, struct record *record)
{
	int64_t *numbers = world_record_carried(record, objects);
	for (size_t i = 0; i < objects; i++)
		numbers += record->objects[i].carried;
	return get_carried(root, "aboard", numbers, carried_by_vehicles(record, objects));
}

static bool get_attached(const cJSON *root, size_t objects, struct record *record)
{
	const char *at = get_text(root, "attached");
	double *numbers = world_record_attached(record, objects);
	if (record->attached_count == 0)
		return at == NULL;
	return get_numbers(at, record->attached_count, numbers);
}

/* Reads `count` whole numbers with `between` between them, and a `;` after the last. Moves *at behind that. */
static bool get_wholes(const char **at, size_t count, char between, int64_t *numbers)
{
	for (size_t i = 0; i < count; i++) {
		char *end;
		errno = 0;
		if (*at == NULL || strchr("-0123456789", **at) == NULL || **at == '\0')
			return false;
		numbers[i] = strtoll(*at, &end, 10);
		if (errno != 0 || *end != (i + 1 < count ? between : ';'))
			return false;
		*at = end + 1;
	}
	return true;
}

static bool get_thrown(const cJSON *root, size_t objects, struct record *record)
{
	struct record_thrown *thrown = &record->thrown;
	struct bearing_grain *grains = world_record_grains(record, objects);
	const char *sums = get_text(root, "thrown"), *at = get_text(root, "grains");
	int64_t numbers[GRAIN_NUMBERS];
	thrown->count = 0;
	if (thrown->room == 0)
		return sums == NULL && at == NULL;
	if (at == NULL || !get_wholes(&sums, SOIL_CLASSES, ';', thrown->thrown) || *sums != '\0' || !get_whole(root, "landed", 0, &thrown->landed) ||
	    !get_whole(root, "lost", 0, &thrown->lost))
		return false;
	while (*at != '\0') {
		if (thrown->count == thrown->room || !get_wholes(&at, GRAIN_NUMBERS, ',', numbers) || !bearing_grain_load(numbers, &grains[thrown->count]))
			return false;
		thrown->count++;
	}
	return true;
}

enum status world_record_damaged(const char *store, const char *why)
{
	return fail_with(STATUS_INPUT, "%s: what its last drive left to go on from is damaged: %s; drive without --resume, "
			 "or furrow reset %s", store, why, shell_path(store).text);
}

static enum status parse_objects(const cJSON *objects, const char *store, const struct scene *scene,
				 struct record *record)
{
	char why[64];
	size_t count = (size_t)cJSON_GetArraySize(objects);
	if (!cJSON_IsArray(objects) || count != scene->object_count) {
		snprintf(why, sizeof why, "%zu objects, not %zu", count, scene->object_count);
		return world_record_damaged(store, why);
	}
	const cJSON *object = objects->child;
	int64_t *carried = world_record_carried(record, count);
	for (size_t i = 0; i < count; carried += record->objects[i].carried, i++, object = object->next)
		if (!get_object(object, scene->objects[i].name, &record->objects[i]) || !get_carried(object, "carried", carried, record->objects[i].carried)) {
			snprintf(why, sizeof why, "object %zu of %zu", i + 1, count);
			return world_record_damaged(store, why);
		}
	return STATUS_OK;
}

static enum status parse_root(const cJSON *root, const char *store, struct record *record)
{
	const cJSON *version = cJSON_GetObjectItemCaseSensitive(root, "version");
	int64_t level, law = 0;
	if (!cJSON_IsObject(root))
		return world_record_damaged(store, "no JSON object");
	if (!cJSON_IsNumber(version) || version->valuedouble != VERSION)
		return fail_with(STATUS_INPUT, "%s: its last drive was made by another furrow, which keeps another record; resume "
				 "it with that, or drive without --resume", store);
	if (!get_whole(root, "level", TILE_LEVEL_MIN, &level) || level > TILE_LEVEL_MAX)
		return world_record_damaged(store, "its level");
	record->level = (int)level;
	if (cJSON_HasObjectItem(root, "law") && (!get_whole(root, "law", 0, &law) || law > INT32_MAX))
		return world_record_damaged(store, "its law of soil");
	record->law = (int)law;
	if (!get_bool(root, "ended", &record->ended))
		return world_record_damaged(store, "whether it ended");
	struct pages_sums *sums = &record->sums;
	if (!get_whole(root, "below", -SUM_MOST, &sums->below) || sums->below > SUM_MOST ||
	    !get_whole(root, "above", -SUM_MOST, &sums->above) || sums->above > SUM_MOST ||
	    !get_whole(root, "compacted", -SUM_MOST, &sums->compacted) || sums->compacted > SUM_MOST ||
	    !get_whole(root, "sunk", 0, &sums->sunk) || sums->sunk > SUM_MOST ||
	    !get_whole(root, "slid", 0, &sums->slid) || sums->slid > SUM_MOST)
		return world_record_damaged(store, "its sums");
	if (cJSON_HasObjectItem(root, "added") && (!get_whole(root, "added", -SUM_MOST, &sums->added) || sums->added > SUM_MOST))
		return world_record_damaged(store, "its added soil");
	if (cJSON_HasObjectItem(root, "carried") && (!get_whole(root, "carried", 0, &sums->carried) || sums->carried > SUM_MOST))
		return world_record_damaged(store, "its soil aboard bodies");
	if (!get_active(root, record))
		return world_record_damaged(store, "what was awake");
	return STATUS_OK;
}

enum status world_record_parse(const struct store_run *run, const char *store, const struct scene *scene,
			 struct record *record)
{
	record->step = run->step;
	record->time = run->time;
	if (run->step < 0 || !isfinite(run->time) || run->time < 0)
		return world_record_damaged(store, "its step or its time");
	cJSON *root = cJSON_ParseWithOpts(run->state, NULL, true);
	enum status status;
	TRY_OR(done, parse_root(root, store, record));
	TRY_OR(done, parse_objects(cJSON_GetObjectItemCaseSensitive(root, "objects"), store, scene, record));
	if (!get_attached(root, scene->object_count, record))
		TRY_OR(done, world_record_damaged(store, "the state of its vehicles"));
	if (!get_aboard(root, scene->object_count, record))
		TRY_OR(done, world_record_damaged(store, "the soil aboard its vehicles"));
	if (!get_thrown(root, scene->object_count, record))
		TRY_OR(done, world_record_damaged(store, "its thrown soil"));
	record->sums.in_flight = world_record_in_flight(record, scene->object_count);
done:
	cJSON_Delete(root);
	return status;
}
