/*
 * Writes a trace: FILE.part while it grows, FILE once it is complete. Noting an access costs the step a look-up and a few bytes
 * into a buffer, and a write for every 64 KiB.
 *
 * - After a failure nothing more is noted or renamed. A FILE is always a complete trace.
 * - A file that is no trace is never replaced. Two drives never write the same trace: the .part is locked, and the lock ends
 * with the process.
 */
#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <xxhash.h>

#include "base/aside.h"
#include "base/key_set.h"
#include "base/limits.h"
#include "page/page.h"

#define BUFFER_BYTES ((size_t)1 << 16)
#define RECORDS_MOST 64 /* bytes that an access and the end add, at most */

struct page_trace {
	char *path;
	struct aside aside;
	int file; /* -1: not begun */
	uint8_t *buffer;
	size_t used;
	XXH3_state_t *hash;
	struct key_set index;
	uint64_t step, accesses;
	struct failure failure; /* sticky */
};

static enum status cannot_write(const struct page_trace *trace)
{
	return fail_with(STATUS_FAILED, "%s: the trace cannot be written: %s; free some disk space, or give another file",
			 trace->path, strerror(errno));
}

static enum status flush(struct page_trace *trace)
{
	XXH3_64bits_update(trace->hash, trace->buffer, trace->used);
	for (size_t at = 0; at < trace->used;) {
		ssize_t written = write(trace->file, trace->buffer + at, trace->used - at);
		if (written < 0 && errno == EINTR)
			continue;
		if (written < 0)
			return cannot_write(trace);
		at += (size_t)written;
	}
	trace->used = 0;
	return STATUS_OK;
}

static void put_bytes(struct page_trace *trace, uint64_t value, int count)
{
	for (int i = 0; i < count; i++)
		trace->buffer[trace->used++] = (uint8_t)(value >> (8 * i));
}

static void put_number(struct page_trace *trace, uint64_t value)
{
	for (; value >= 0x80; value >>= 7)
		trace->buffer[trace->used++] = (uint8_t)(value | 0x80);
	trace->buffer[trace->used++] = (uint8_t)value;
}

/* --- life --- */

/* 2 */
static enum status check_replaceable(const char *path)
{
	char magic[sizeof PAGE_TRACE_MAGIC - 1];
	struct stat found;
	if (stat(path, &found) != 0)
		return errno == ENOENT ? STATUS_OK
				       : fail_with(STATUS_FAILED, "%s: %s; give another file for the trace", path,
						   strerror(errno));
	bool replaceable = S_ISREG(found.st_mode) && found.st_size == 0;
	if (S_ISREG(found.st_mode) && !replaceable) {
		FILE *file = input_open(path);
		replaceable = file != NULL && fread(magic, sizeof magic, 1, file) == 1 &&
			      memcmp(magic, PAGE_TRACE_MAGIC, sizeof magic) == 0;
		if (file != NULL)
			fclose(file);
	}
	return replaceable ? STATUS_OK
			   : fail_with(STATUS_FAILED, "%s: is there and is no trace; give another file", path);
}

static enum status begin(struct page_trace *trace)
{
	int file = output_create(trace->aside.part, O_WRONLY);
	if (file < 0)
		return fail_with(STATUS_FAILED, "%s: %s: %s; %s", trace->path, trace->aside.part, input_problem(),
				 limits_advice(errno, "give a file that can be written"));
	/* Between open and lock another drive may have published this very file, so that it is no .part any more. */
	struct stat found, named;
	if (flock(file, LOCK_EX | LOCK_NB) != 0 || stat(trace->aside.part, &named) != 0 || fstat(file, &found) != 0 ||
	    found.st_ino != named.st_ino) {
		close(file);
		return fail_with(STATUS_FAILED, "%s: another drive writes this trace; give another file", trace->path);
	}
	trace->file = file;
	trace->aside.begun = true;
	/* The file of a killed drive is overwritten. */
	if (found.st_size > 0 && ftruncate(file, 0) != 0)
		return cannot_write(trace);
	memcpy(trace->buffer, PAGE_TRACE_MAGIC, sizeof PAGE_TRACE_MAGIC - 1);
	trace->used = sizeof PAGE_TRACE_MAGIC - 1;
	put_bytes(trace, PAGE_TRACE_VERSION, 4);
	return STATUS_OK;
}

enum status page_trace_create(const char *path, struct page_trace **out)
{
	TRY(check_replaceable(path));
	struct page_trace *trace = mem_calloc(1, sizeof *trace);
	TRY_MEM(trace, "a trace");
	trace->file = -1;
	trace->path = mem_strdup(path);
	trace->buffer = mem_alloc(BUFFER_BYTES, 1);
	trace->hash = XXH3_createState();
	enum status status;
	if (trace->path == NULL || trace->buffer == NULL || trace->hash == NULL)
		TRY_OR(failed, fail_memory("a trace"));
	TRY_OR(failed, aside_name(&trace->aside, trace->path));
	XXH3_64bits_reset(trace->hash);
	struct stat found; /* a device may be given for it; a file that is no trace keeps what it has */
	if (stat(trace->aside.part, &found) == 0 && S_ISREG(found.st_mode))
		TRY_OR(failed, check_replaceable(trace->aside.part));
	TRY_OR(failed, begin(trace));
	*out = trace;
	return STATUS_OK;
failed:
	page_trace_destroy(trace);
	return status;
}

void page_trace_destroy(struct page_trace *trace)
{
	if (trace == NULL)
		return;
	aside_finish(&trace->aside);
	if (trace->file >= 0)
		close(trace->file);
	key_set_finish(&trace->index);
	XXH3_freeState(trace->hash);
	mem_free_all(trace->buffer, trace->path, trace);
}

/* --- what is noted --- */

static enum status note_access(struct page_trace *trace, uint64_t step, uint64_t key, enum page_access kind,
			       bool resident)
{
	uint32_t number;
	bool fresh;
	TRY(key_set_number(&trace->index, key, &number, &fresh));
	if (BUFFER_BYTES - trace->used < RECORDS_MOST)
		TRY(flush(trace));
	if (step > trace->step)
		put_number(trace, (step - trace->step) << 1 | 1);
	put_number(trace, (uint64_t)number << 3 | (uint64_t)resident << 2 | (uint64_t)kind << 1);
	if (fresh)
		put_bytes(trace, key, 8);
	trace->step = step;
	trace->accesses++;
	return STATUS_OK;
}

void page_trace_access(struct page_trace *trace, uint64_t step, uint64_t key, enum page_access kind,
		       bool resident)
{
	if (trace == NULL || trace->failure.status != STATUS_OK)
		return; /* 1 */
	assert(trace->aside.begun && step >= trace->step && key >> PAGE_TRACE_KEY_BITS == 0);
	enum status status = note_access(trace, step, key, kind, resident);
	if (status != STATUS_OK)
		failure_capture(&trace->failure, status);
}

enum status page_trace_status(const struct page_trace *trace)
{
	return trace == NULL || trace->failure.status == STATUS_OK ? STATUS_OK : failure_restore(&trace->failure);
}

const char *page_trace_path(const struct page_trace *trace)
{
	return trace != NULL ? trace->path : NULL;
}

static enum status publish(struct page_trace *trace)
{
	put_number(trace, 1);
	put_bytes(trace, trace->accesses, 8);
	put_bytes(trace, trace->index.count, 8);
	TRY(flush(trace));
	put_bytes(trace, XXH3_64bits_digest(trace->hash), 8);
	TRY(flush(trace));
	if (fsync(trace->file) != 0)
		return cannot_write(trace);
	return aside_publish(&trace->aside);
}

enum status page_trace_publish(struct page_trace *trace)
{
	TRY(page_trace_status(trace));
	if (trace == NULL)
		return STATUS_OK;
	const enum status status = publish(trace);
	if (status != STATUS_OK)
		failure_capture(&trace->failure, status);
	return status;
}
