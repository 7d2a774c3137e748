"""From C to a shared object, and the cache that saves doing it twice."""
