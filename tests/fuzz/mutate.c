/* The driver's changes of bytes: what LLVMFuzzerMutate() is where there is no libFuzzer. */
#include "driver.h"

#include <string.h>

uint64_t driver_random_state;

static uint64_t below(uint64_t bound)
{
	return fuzz_below(&driver_random_state, bound);
}

static size_t grow(uint8_t *data, size_t size, size_t at, const void *bytes, size_t count)
{
	memmove(data + at + count, data + at, size - at);
	memcpy(data + at, bytes, count);
	return size + count;
}

/* An integer of 1, 2, 4 or 8 bytes, either end first: a step from it, or another at its place. */
static void change_integer(uint8_t *data, size_t size)
{
	size_t bytes = (size_t)1 << below(4);
	if (bytes > size)
		bytes = 1;
	size_t at = below(size - bytes + 1);
	bool big = below(2), replace = below(2);
	uint64_t value = 0;
	for (size_t i = 0; i < bytes; i++)
		value |= (uint64_t)data[at + (big ? bytes - 1 - i : i)] << (8 * i);
	value = replace ? (uint64_t)fuzz_integer(&driver_random_state) : value + below(71) - 35;
	for (size_t i = 0; i < bytes; i++)
		data[at + (big ? bytes - 1 - i : i)] = (uint8_t)(value >> (8 * i));
}

static size_t insert_word(uint8_t *data, size_t size, size_t room, size_t at)
{
	size_t count = 0;
	while (fuzz_words[count] != NULL)
		count++;
	if (count == 0)
		return size;
	const char *word = fuzz_words[below(count)];
	size_t length = strlen(word);
	return size + length <= room ? grow(data, size, at, word, length) : size;
}

/* A part of another input of the corpus, put in or written over. */
static size_t splice(uint8_t *data, size_t size, size_t room, size_t at)
{
	const struct input *other = driver_any_input();
	size_t from = below(other->size), count = 1 + below(other->size - from);
	if (below(2) && size + count <= room)
		return grow(data, size, at, other->data + from, count);
	if (count > size - at)
		count = size - at;
	memcpy(data + at, other->data + from, count);
	return size;
}

static size_t change_once(uint8_t *data, size_t size, size_t room)
{
	uint8_t copy[256];
	size_t at = below(size), count = 1 + below(below(4) ? 8 : 64);
	if (count > size - at)
		count = size - at;
	switch (below(10)) {
	case 0:
		data[at] ^= (uint8_t)(1u << below(8));
		return size;
	case 1:
		data[at] = (uint8_t)below(256);
		return size;
	case 2:
	case 3:
		change_integer(data, size);
		return size;
	case 4:
		if (count == size)
			return size;
		memmove(data + at, data + at + count, size - at - count);
		return size - count;
	case 5: /* the block again, somewhere */
		if (size + count > room)
			return size;
		memcpy(copy, data + at, count);
		return grow(data, size, below(size + 1), copy, count);
	case 6:
		memset(data + at, below(2) ? 0 : (int)below(256), count);
		return size;
	case 7:
		return splice(data, size, room, at);
	case 8: /* cut short */
		return below(4) == 0 ? at + 1 : size;
	default:
		return insert_word(data, size, room, at);
	}
}

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room)
{
	if (size == 0 && room > 0)
		data[size++] = (uint8_t)below(256);
	uint64_t changes = (uint64_t)1 << below(4);
	for (uint64_t i = 0; i < changes && size > 0; i++)
		size = change_once(data, size, room);
	return size;
}
