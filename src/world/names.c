/*
 * Names of a host's world: which body has a name, and which made name is free next.
 *
 * A hash table leads from the hash of a name to the number of the body that had it last. It is made when it is first asked for, and again
 * after a rollback. The body itself tells whether it still has that name. Where it has another one, two names have the same hash, and all
 * bodies are looked at.
 */
#include <stdio.h>
#include <string.h>

#include "world/internal.h"

static const char *name_of(const struct world *world, int32_t number)
{
	const struct body *body = world_body(world, (size_t)number);
	return body != NULL ? body->object->name : NULL;
}

static bool is_there(const struct world *world, int32_t number)
{
	const struct body *body = world_body(world, (size_t)number);
	return body != NULL && !body->host.removed;
}

/* FNV-1a. */
static uint64_t key_of(const char *name)
{
	uint64_t hash = 0xcbf29ce484222325ull;
	for (const char *c = name; *c != '\0'; c++)
		hash = (hash ^ (unsigned char)*c) * 0x100000001b3ull;
	return hash >> 1; /* UINT64_MAX is no key */
}

static enum status put(struct world_names *names, const char *name, int32_t number)
{
	uint32_t place;
	bool fresh;
	TRY(key_set_number(&names->keys, key_of(name), &place, &fresh));
	TRY(mem_grow(&names->numbers, &names->room, place + 1, sizeof *names->numbers, "the names of bodies"));
	names->numbers[place] = number;
	return STATUS_OK;
}

/* Adds the bodies that the table does not know yet. Without memory for it, all bodies are looked at. */
static bool fill(struct world *world)
{
	struct world_names *names = &world->names;
	for (; names->known < world->body_count; names->known++) {
		const int32_t number = (int32_t)names->known;
		const char *name = name_of(world, number);
		if (name != NULL && is_there(world, number) && put(names, name, number) != STATUS_OK) {
			world_names_forget(world);
			return false;
		}
	}
	return true;
}

static int32_t look_at_all(const struct world *world, const char *name)
{
	for (size_t i = 0; i < world->body_count; i++)
		if (is_there(world, (int32_t)i) && strcmp(name_of(world, (int32_t)i), name) == 0)
			return (int32_t)i;
	return -1;
}

int32_t world_names_find(struct world *world, const char *name)
{
	uint32_t place = 0;
	if (!fill(world))
		return look_at_all(world, name);
	if (!key_set_find(&world->names.keys, key_of(name), &place))
		return -1;
	const int32_t number = world->names.numbers[place];
	const char *has = name_of(world, number);
	if (has == NULL || strcmp(has, name) != 0)
		return look_at_all(world, name);
	return is_there(world, number) ? number : -1;
}

void world_names_forget(struct world *world)
{
	struct world_names *names = &world->names;
	key_set_clear(&names->keys);
	names->known = 0;
	names->taken = 0;
}

void world_names_free(struct world *world)
{
	key_set_finish(&world->names.keys);
	mem_free(world->names.numbers);
	world->names = (struct world_names){.known = 0};
}

void world_names_next(struct world *world, char *name, size_t room)
{
	do
		snprintf(name, room, "body-%u", ++world->names.taken);
	while (world_names_find(world, name) >= 0);
}

void world_names_freed(struct world *world, const char *name)
{
	struct world_names *names = &world->names;
	unsigned number = 0;
	char made[32];
	if (sscanf(name, "body-%9u", &number) != 1 || number == 0 || number > names->taken)
		return;
	snprintf(made, sizeof made, "body-%u", number);
	if (strcmp(made, name) == 0)
		names->taken = number - 1;
}
