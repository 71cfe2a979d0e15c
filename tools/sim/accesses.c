/*
 * Reading a trace. The file is untrusted: every record is checked before it is believed, and what is
 * allocated is bounded by the bytes that are there.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include <xxhash.h>

#include "base/key_set.h"
#include "sim/sim.h"

#define TRACE_NUMBER_MOST 10                 /* bytes of a LEB128 of 64 bits */
#define TRACE_ACCESSES_MOST ((1u << 30) - 2) /* sums over twice as many fit 31 bits */

struct parsing {
	const char *path;
	const uint8_t *bytes;
	size_t size, at;
	struct key_set index;
	struct sim_accesses *out;
	size_t access_room, tile_room;
	uint64_t step;
	bool ended;
};

static enum status cut(const struct parsing *parsing)
{
	return fail_with(STATUS_INPUT, "%s: the trace is cut short after %zu bytes; copy it again, or drive again",
			 parsing->path, parsing->size);
}

static enum status damaged(const struct parsing *parsing, const char *why)
{
	return fail_with(STATUS_INPUT, "%s: the trace is damaged before byte %zu: %s; copy it again, or drive again",
			 parsing->path, parsing->at, why);
}

static uint64_t fetch(const uint8_t *bytes, int count)
{
	uint64_t value = 0;
	for (int i = 0; i < count; i++)
		value |= (uint64_t)bytes[i] << (8 * i);
	return value;
}

static enum status take_bytes(struct parsing *parsing, int count, uint64_t *value)
{
	if (parsing->size - parsing->at < (size_t)count)
		return cut(parsing);
	*value = fetch(parsing->bytes + parsing->at, count);
	parsing->at += (size_t)count;
	return STATUS_OK;
}

static enum status take_number(struct parsing *parsing, uint64_t *value)
{
	*value = 0;
	for (int i = 0; i < TRACE_NUMBER_MOST; i++) {
		if (parsing->at == parsing->size)
			return cut(parsing);
		uint8_t byte = parsing->bytes[parsing->at++];
		if (i == TRACE_NUMBER_MOST - 1 && byte > 1)
			break;
		*value |= (uint64_t)(byte & 0x7f) << (7 * i);
		if (byte < 0x80)
			return STATUS_OK;
	}
	return damaged(parsing, "a number of more than 64 bits");
}

/* --- records --- */

static enum status add_tile(struct parsing *parsing)
{
	struct sim_accesses *out = parsing->out;
	uint64_t key = 0;
	uint32_t number;
	bool fresh = false;
	TRY(take_bytes(parsing, 8, &key));
	if (key >> PAGE_TRACE_KEY_BITS != 0)
		return damaged(parsing, "a key that no tile has");
	TRY(key_set_number(&parsing->index, key, &number, &fresh));
	if (!fresh)
		return damaged(parsing, "a tile that came before comes as a new one");
	TRY(mem_grow(&out->keys, &parsing->tile_room, out->tile_count + 1, sizeof *out->keys, "the trace"));
	out->keys[out->tile_count++] = key;
	return STATUS_OK;
}

static enum status add_access(struct parsing *parsing, uint64_t record)
{
	struct sim_accesses *out = parsing->out;
	uint64_t number = record >> 3;
	unsigned kind = record >> 1 & 1;
	if (number > out->tile_count)
		return damaged(parsing, "a tile that has not come yet");
	if (out->count == TRACE_ACCESSES_MOST)
		return fail_with(STATUS_INPUT, "%s: has more than %u accesses; trace fewer steps", parsing->path,
				 TRACE_ACCESSES_MOST);
	if (number == out->tile_count)
		TRY(add_tile(parsing));
	if (out->count == parsing->access_room) {
		parsing->access_room = mem_room(parsing->access_room, out->count + 1);
		TRY(mem_resize(&out->tiles, parsing->access_room, sizeof *out->tiles, "the trace"));
		TRY(mem_resize(&out->steps, parsing->access_room, sizeof *out->steps, "the trace"));
	}
	out->tiles[out->count] = (uint32_t)number;
	out->steps[out->count++] = parsing->step;
	++*((record >> 2 & 1) != 0 ? &out->hits[kind] : &out->misses[kind]);
	return STATUS_OK;
}

static enum status end(struct parsing *parsing)
{
	uint64_t accesses = 0, tiles = 0, hash = 0;
	TRY(take_bytes(parsing, 8, &accesses));
	TRY(take_bytes(parsing, 8, &tiles));
	size_t hashed = parsing->at;
	TRY(take_bytes(parsing, 8, &hash));
	if (accesses != parsing->out->count || tiles != parsing->out->tile_count)
		return damaged(parsing, "it does not have the accesses and tiles it says");
	if (hash != XXH3_64bits(parsing->bytes, hashed))
		return damaged(parsing, "its checksum differs");
	if (parsing->at != parsing->size)
		return damaged(parsing, "something follows its end");
	parsing->ended = true;
	return STATUS_OK;
}

static enum status take_record(struct parsing *parsing)
{
	uint64_t record = 0;
	TRY(take_number(parsing, &record));
	if ((record & 1) == 0)
		return add_access(parsing, record);
	if (record == 1)
		return end(parsing);
	if (record >> 1 > (uint64_t)INT64_MAX - parsing->step)
		return damaged(parsing, "a step beyond any");
	parsing->step += record >> 1;
	return STATUS_OK;
}

/* --- the whole --- */

static enum status check_header(struct parsing *parsing)
{
	size_t magic = sizeof PAGE_TRACE_MAGIC - 1;
	if (parsing->size < magic || memcmp(parsing->bytes, PAGE_TRACE_MAGIC, magic) != 0)
		return fail_with(STATUS_INPUT, "%s: is no trace; give a file that furrow drive --trace made",
				 parsing->path);
	if (parsing->size < PAGE_TRACE_HEADER)
		return cut(parsing);
	uint64_t version = fetch(parsing->bytes + magic, 4);
	if (version != PAGE_TRACE_VERSION)
		return fail_with(STATUS_INPUT, "%s: is a trace of version %llu and this furrow reads %d; trace it again",
				 parsing->path, (unsigned long long)version, PAGE_TRACE_VERSION);
	parsing->at = PAGE_TRACE_HEADER;
	return STATUS_OK;
}

enum status sim_accesses_parse(const char *path, const uint8_t *bytes, size_t size, struct sim_accesses *out)
{
	struct parsing parsing = {.path = path, .bytes = bytes, .size = size, .out = out};
	*out = (struct sim_accesses){.count = 0};
	enum status status;
	TRY_OR(done, check_header(&parsing));
	while (!parsing.ended)
		TRY_OR(done, take_record(&parsing));
done:
	key_set_finish(&parsing.index);
	if (status != STATUS_OK)
		sim_accesses_finish(out);
	return status;
}

static enum status read_all(const char *path, uint8_t **bytes, size_t *size)
{
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%s: %s; give a trace that can be read", path, input_problem());
	enum status status = STATUS_OK;
	for (size_t room = 1 << 16; !feof(file); room *= 2) {
		TRY_OR(done, mem_resize(bytes, room, 1, "the trace"));
		*size += fread(*bytes + *size, 1, room - *size, file);
		if (ferror(file))
			TRY_OR(done, fail_with(STATUS_INPUT, "%s: %s; give a trace that can be read", path, strerror(errno)));
	}
done:
	fclose(file);
	return status;
}

enum status sim_accesses_read(const char *path, struct sim_accesses *out)
{
	uint8_t *bytes = NULL;
	size_t size = 0;
	enum status status;
	TRY_OR(done, read_all(path, &bytes, &size));
	TRY_OR(done, sim_accesses_parse(path, bytes, size, out));
done:
	mem_free(bytes);
	return status;
}

void sim_accesses_finish(struct sim_accesses *accesses)
{
	mem_free_all(accesses->tiles, accesses->steps, accesses->keys);
	*accesses = (struct sim_accesses){.count = 0};
}
