#include "vehicle/guard.h"

#include "vehicle_mujoco.h"
#include <pthread.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static unsigned guards; /* calls that run now */
static void (*error_before)(const char *text), (*warning_before)(const char *text);

static _Thread_local jmp_buf *back; /* NULL: no guarded call of this thread runs */
static _Thread_local char error_text[256], warning_text[256];

static void on_error(const char *text)
{
	if (back != NULL) {
		snprintf(error_text, sizeof error_text, "%s", text);
		longjmp(*back, 1);
	}
	if (error_before != NULL)
		error_before(text);
	abort(); /* MuJoCo cannot go on after an error */
}

static void on_warning(const char *text)
{
	if (back == NULL && warning_before != NULL)
		warning_before(text);
	else if (back != NULL && warning_text[0] == '\0')
		snprintf(warning_text, sizeof warning_text, "%s", text);
}

static void begin(void)
{
	pthread_mutex_lock(&lock);
	if (guards++ == 0) {
		error_before = mju_user_error;
		warning_before = mju_user_warning;
		mju_user_error = on_error;
		mju_user_warning = on_warning;
	}
	pthread_mutex_unlock(&lock);
}

static void end(void)
{
	pthread_mutex_lock(&lock);
	if (--guards == 0) {
		mju_user_error = error_before;
		mju_user_warning = warning_before;
	}
	pthread_mutex_unlock(&lock);
}

enum status vehicle_guard(const char *what, void (*call)(void *argument), void *argument)
{
	jmp_buf here;
	warning_text[0] = '\0';
	begin();
	const bool failed = setjmp(here) != 0;
	if (!failed) {
		back = &here;
		call(argument);
	}
	back = NULL;
	end();
	return failed ? fail_with(STATUS_FAILED, "%s: MuJoCo " VEHICLE_MUJOCO_VERSION " says: %s; change the model", what, error_text) : STATUS_OK;
}

const char *vehicle_guard_warning(void)
{
	return warning_text;
}
